// Hinges (conditions.hpp) on the edges of a mesh: at joints of two triangles (surface_mesh.hpp), and on the boundary, where the
// ground is the other side.
#pragma once

#include <map>
#include <vector>

#include "base/types.hpp"
#include "conditions.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::system {

struct HingeEdge {
  Index number;             ///< of mesh.joints(), or on the boundary their count and 3 t + s
  mesh::Segment edge;       ///< ascending
  mesh::TriangleSide side;  ///< of one of its triangles
};

/// Whether a number is that of a side on the boundary.
[[nodiscard]] inline bool on_boundary(const mesh::SurfaceMesh& mesh, Index number) {
  return number >= static_cast<Index>(mesh.joints().size());
}
/// The edges of a hinge, each once. Throws UserError for an unknown group, and where more than two sheets meet.
[[nodiscard]] std::vector<HingeEdge> edges_of(const mesh::SurfaceMesh& mesh, const Hinge& hinge);
/// Edges of all hinges, and their stiffness k [N], by number. Throws as edges_of(), and for an edge on two hinges.
struct HingedEdge {
  HingeEdge at;
  double stiffness;
};
[[nodiscard]] std::map<Index, HingedEdge> hinged_edges(const mesh::SurfaceMesh& mesh, const std::vector<Hinge>& hinges);

}  // namespace voile::system

// Hinges (conditions.hpp) among the joints of a mesh (surface_mesh.hpp).
#pragma once

#include <vector>

#include "base/types.hpp"
#include "conditions.hpp"

namespace voile::mesh {
class SurfaceMesh;
}  // namespace voile::mesh

namespace voile::system {

/// Numbers of the joints on the edges of a hinge, ascending. Throws UserError for an unknown group, or edges that are no joint of two
/// triangles.
[[nodiscard]] std::vector<Index> joints_of(const mesh::SurfaceMesh& mesh, const Hinge& hinge);
/// Stiffness k of each joint, infinite where it is no hinge [N]. Throws as joints_of(), and for an edge on two hinges.
[[nodiscard]] std::vector<double> hinge_stiffness(const mesh::SurfaceMesh& mesh, const std::vector<Hinge>& hinges);

}  // namespace voile::system

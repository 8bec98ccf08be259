// Vertices that lie at the same place without being one: slits, or parts that a program exported unmerged.
#pragma once

#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

/// What coincides within a distance.
struct Coincidence {
  Index places = 0;                              ///< where two or more vertices lie
  Index vertices = 0;                            ///< how many lie there in all
  Vec3 first = Vec3::Zero();                     ///< one of the places [m]
  Index joints = 0;                              ///< vertices on a boundary that share a place with one that is not
  Vec3 joint = Vec3::Zero();                     ///< one of these places [m]
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< box around all of them [m]
};

/// Edges of a single triangle, each ascending, in order. Not collective.
[[nodiscard]] std::vector<Segment> rim_edges(const MeshData& data);

/// A millionth of the mesh's extent, but at most a tenth of its shortest edge: single precision passes, triangles do
/// not collapse. [m]
[[nodiscard]] double default_merge_tolerance(const MeshData& data);

/// Counts vertices of triangles that are closer than `tolerance` [m] to another one. Not collective.
[[nodiscard]] Coincidence find_coincident(const MeshData& data, double tolerance);

/// Makes one of vertices that lie closer together than `tolerance` [m], also through others, if one of them is on a boundary
/// edge; the one with the lowest number stays. Where a part ends inside another they are joined (surface_mesh.hpp). Layers that lie on each other stay apart inside their boundaries. Groups follow; line
/// elements and vertices that are then there twice are dropped. Returns how many vertices went. Not collective.
/// `edges`: ascending pairs of vertices that take the new numbers. Throws UserError if the tolerance lets a triangle collapse.
Index merge_coincident(MeshData& data, double tolerance, std::vector<Segment>* edges = nullptr);

/// Each vertex v becomes target[v], which is its own target. Groups follow; triangles that then have a vertex twice are dropped,
/// line elements that are there twice too. `edges` as above. Returns how many vertices went. Not collective.
Index join_vertices(MeshData& data, const std::vector<Index>& target, std::vector<Segment>* edges = nullptr);

}  // namespace voile::mesh

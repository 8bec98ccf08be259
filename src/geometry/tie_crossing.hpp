// Parts that pass through each other without ending there, as the plates of an egg crate.
//
// A side of one that has ends on both sides of a triangle of the other pierces it; a vertex that lies on it does if its own triangles
// are on both sides. Where no shape is lost, vertices near the line in which two triangles cross first move onto it.
#pragma once

#include <vector>

#include "intersections.hpp"
#include "tie_points.hpp"
#include "tie_surface.hpp"

namespace voile::geometry {

/// Pairs of triangles of which one pierces the other, but not only at its rim, as where a web stands on a sheet. `rims`: edges that
/// count as rims besides. Exact but for `tolerance` [m]. Not collective.
[[nodiscard]] std::vector<TrianglePair> crossing_triangles(const mesh::MeshData& data, double tolerance,
                                                           const std::vector<mesh::Segment>& rims = {});

/// Moves vertices near crossings onto them, and joins those of two parts that lie at one place there; `rims` follow. Returns how many
/// moved.
Index move_to_crossings(mesh::MeshData& data, double tolerance, std::vector<mesh::Segment>& rims);

/// Adds the vertices at which sides pierce triangles. Returns how many there are.
Index pierce(const mesh::MeshData& data, const std::vector<TrianglePair>& pairs, TiePoints& points);

/// Pieces of the lines in which the triangles of pairs cross, from vertex to vertex. After TiePoints::sort().
[[nodiscard]] std::vector<mesh::Segment> lines_of(const mesh::MeshData& data, const std::vector<TrianglePair>& pairs,
                                                  const TiePoints& points);

}  // namespace voile::geometry

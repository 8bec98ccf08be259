// Which triangles intersect: an independent check of contact, with exact predicates and none of the contact code.
//
// Symbols   T_i, T_j   closed triangles (interior, edges, corners) of the given coordinates taken as exact numbers
//           S_ij       what they have in common by numbering: nothing, a vertex or an edge
//
// A pair intersects if T_i and T_j have a point in common that is not in S_ij:
//   S_ij empty      T_i and T_j have any point in common: touching counts, also at vertices that coincide but have
//                   different numbers
//   S_ij a vertex   the edge of one opposite to it meets the other: a ray from the common vertex that runs inside both
//                   leaves one of them through that edge
//   S_ij an edge    they are coplanar and on the same side of the edge (folded exactly onto each other)
//   all three       always (two triangles on the same vertices)
// Triangles of zero area count as the segment or point that they are; two of these that share an edge are not compared.
//
// Candidates are pairs of overlapping bounding boxes, by Zomorodian and Edelsbrunner, Fast software for box
// intersections, International Journal of Computational Geometry and Applications 12 (2002) 143-172, as implemented in
// CGAL, as are the predicates.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::geometry {

/// Numbers of two triangles, the lower one first.
using TrianglePair = std::pair<Index, Index>;

/// What is to be done of work that several share.
struct Share {
  int part = 0, parts = 1;
};

/// All pairs of intersecting triangles, ascending. Positions in any unit (nothing depends on the scale).
/// Not collective, no tolerance, the caller owns the result; O(n log^3 n) plus the pairs of overlapping boxes.
/// Throws InternalError for coordinates that are not finite or vertex numbers that do not exist.
[[nodiscard]] std::vector<TrianglePair> intersecting_triangles(const std::vector<Vec3>& positions,
                                                               const std::vector<mesh::Triangle>& triangles);

/// The same without the pairs for which skip(body of the one, body of the other) is true: e.g. pairs inside one
/// obstacle. `body` has a number for each triangle; `skip` may be asked in either order, as often as there are pairs of
/// overlapping boxes. `share`: only this part of the pairs, which are divided by where they are, so that each pair is in one.
/// Throws also InternalError if `body` has another length than `triangles`.
[[nodiscard]] std::vector<TrianglePair> intersecting_triangles(const std::vector<Vec3>& positions,
                                                               const std::vector<mesh::Triangle>& triangles,
                                                               const std::vector<Index>& body,
                                                               const std::function<bool(Index, Index)>& skip,
                                                               Share fraction = {});

/// Writes the triangles of the pairs as legacy VTK (ASCII polygons, .vtk; coordinates as passed [m]), which ParaView
/// opens, with the cell fields `pair` (position in `pairs`), `triangle` (its number) and `body` (0 if `body` is empty).
/// A triangle occurs once for each of its pairs. Replaces the file. Not collective. Throws UserError if it cannot be
/// written, InternalError if `body` is neither empty nor as long as `triangles` or a pair names no triangle.
void write_pairs(const std::filesystem::path& file, const std::vector<Vec3>& positions,
                 const std::vector<mesh::Triangle>& triangles, const std::vector<Index>& body,
                 const std::vector<TrianglePair>& pairs);

/// Version of the CGAL library in use.
[[nodiscard]] std::string cgal_version();

}  // namespace voile::geometry

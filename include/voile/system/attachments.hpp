// Vertices that are held to the surface of an obstacle, wherever it goes and however it deforms.
//
// Symbols   X_0     where a vertex is when it is taken hold of                                                    [m]
//           y_0     the point of the obstacle nearest to it then, at weights l_i of the corners p_i of a triangle  [m]
//           F       axes of that triangle: along its first side, in its plane square to that, normal
//   y(t) = sum_i l_i p_i(t) + F(t) d,   d = F_0^T (X_0 - y_0), or (0, 0, +-gap) on the side on which X_0 lies
//   W    = k/2 |x - y(t)|^2           k: a share of the stiffness, spread as loads are (boundary_conditions.hpp)
//   x    = y(t)                       of a hard one
#pragma once

#include <string>
#include <vector>

#include "voile/mesh/surface_mesh.hpp"
#include "voile/system/conditions.hpp"

namespace voile::system {

/// What is remembered of one vertex, alike on all ranks.
struct Anchor {
  int attachment = 0;  ///< Attachment::number
  Index vertex = 0;    ///< of the mesh
  Index triangle = 0;  ///< of the obstacle
  Vec2 weights;        ///< of its second and third corner
  Vec3 offset;         ///< d, from there in the axes of the triangle [m]
};

/// As rows of eight numbers, for files; and back.
[[nodiscard]] std::vector<double> numbers_of(const std::vector<Anchor>& anchors);
[[nodiscard]] std::vector<Anchor> anchors_of(const std::vector<double>& numbers);

/// Where an anchor's place is, from the corners of the obstacle [m].
[[nodiscard]] Vec3 anchor_place(const Anchor& anchor, const mesh::Triangle& triangle, const std::vector<Vec3>& points);

/// Anchors of vertices at `places`, to the surface of `points` and `triangles` (of non-zero area, at least one).
/// Not collective.
[[nodiscard]] std::vector<Anchor> make_anchors(const Attachment& attachment, const std::vector<Index>& vertices,
                                               const std::vector<Vec3>& places, const std::vector<Vec3>& points,
                                               const std::vector<mesh::Triangle>& triangles);

/// The vertices of the groups of an attachment, ascending, each once. Not collective. Throws UserError.
[[nodiscard]] std::vector<Index> vertices_of(const mesh::SurfaceMesh& mesh, const Attachment& attachment);

}  // namespace voile::system

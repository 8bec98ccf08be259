// Gradients of fields at the corners of a triangle, from the vertices around, developed into its plane.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::adapt {

/// The corners of triangle t in its plane, corner 0 as the origin [m].
[[nodiscard]] std::array<Vec2, 3> plane_of(const mesh::SurfaceMesh& mesh, Index t);

struct DevelopedPoint {
  Index vertex;
  Vec2 at;  ///< [m]
};
/// Vertices of the triangles within `rings` rings around corner i of t, along a tree of triangles that crosses no crease.
[[nodiscard]] std::vector<DevelopedPoint> develop(const mesh::SurfaceMesh& mesh, Index t, int i, int rings);

/// Gradient of a field (columns: directions of the plane of t) at corner i of t, from polynomials of the degree (2 or 3)
/// through the corner, fitted to the points around; of a lower degree if these do not suffice.
[[nodiscard]] Eigen::Matrix<double, 3, 2> corner_gradient(const mesh::SurfaceMesh& mesh, Index t, int i,
                                                          const std::vector<Vec3>& field, int degree);

}  // namespace voile::adapt

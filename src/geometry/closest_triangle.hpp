// The triangle of a surface that is nearest to a point, by CGAL's tree of boxes, and where in it.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::geometry {

/// Barycentric weights of the point of a triangle that is nearest to p. `beside` >= 0: weights that are negative by no more
/// are kept, so that the point may lie a little beside the triangle. Not collective.
[[nodiscard]] Vec3 nearest_weights(const Vec3& p, const std::array<Vec3, 3>& corners, double beside = 0.0);

class ClosestTriangle {
 public:
  /// Copies what it needs. At least one triangle; those without area are never found. Not collective.
  ClosestTriangle(const std::vector<Vec3>& positions, const std::vector<mesh::Triangle>& triangles);
  ~ClosestTriangle();
  ClosestTriangle(ClosestTriangle&&) noexcept;
  ClosestTriangle& operator=(ClosestTriangle&&) noexcept;

  /// Number of the triangle. Where several are equally near, any of them. Not collective.
  [[nodiscard]] Index find(const Vec3& point) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voile::geometry

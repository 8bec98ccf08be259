// Elements as triangles: those of second order by what their nodes span, quadrangles by a diagonal; shared by this room and the
// program voile-gmsh.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "base/types.hpp"

namespace voile::formats {

/// Local numbers of the corners of the triangles and quadrangles that an element of `corners` corners (2: a line) and
/// `nodes` nodes is divided into: itself if it has no more nodes than corners. Nodes count as in Gmsh and Abaqus: corners,
/// middles of the sides from the one after the first corner on, the centre. Empty if there is no such element.
[[nodiscard]] inline std::vector<std::vector<std::size_t>> first_order_parts(std::size_t corners, std::size_t nodes) {
  if (corners == 1 && nodes == 1) return {{0}};
  if (corners == 2 && nodes == 2) return {{0, 1}};
  if (corners == 2 && nodes == 3) return {{0, 2}, {2, 1}};
  if (corners == 3 && nodes == 3) return {{0, 1, 2}};
  if (corners == 3 && nodes == 6) return {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};
  if (corners == 4 && nodes == 4) return {{0, 1, 2, 3}};
  if (corners == 4 && nodes == 8) return {{0, 4, 7}, {4, 1, 5}, {5, 2, 6}, {6, 3, 7}, {4, 5, 6, 7}};
  if (corners == 4 && nodes == 9) return {{0, 4, 8, 7}, {4, 1, 5, 8}, {8, 5, 2, 6}, {7, 8, 6, 3}};
  return {};
}

/// Whether the quadrangle a, b, c, d is better divided from b to d than from a to c: by the shorter diagonal, unless that lies
/// outside. Where both are as long, but for round-off, it is not: meshes that differ in the last digits alone are split alike.
[[nodiscard]] inline bool second_diagonal_is_better(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  constexpr double rounding = 1e-6;
  const Vec3 normal = (c - a).cross(d - b);
  const auto lie_inside = [&](const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
    return (q - p).cross(r - p).dot(normal) > 0.0 && (r - p).cross(s - p).dot(normal) > 0.0;
  };
  const bool first = lie_inside(a, b, c, d), second = lie_inside(b, c, d, a);
  if (first != second) return second;
  return (d - b).norm() < (1.0 - rounding) * (c - a).norm();
}

}  // namespace voile::formats

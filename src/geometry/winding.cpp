#include "winding.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

namespace voile::geometry {

using mesh::Triangle;

bool is_closed(const std::vector<Triangle>& triangles) {
  std::set<std::pair<Index, Index>> edges;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k)
      if (!edges.emplace(t[k], t[(k + 1) % 3]).second) return false;
  return std::all_of(edges.begin(), edges.end(), [&](const auto& e) { return edges.count({e.second, e.first}) > 0; });
}

double winding_number(const Vec3& point, const std::vector<Vec3>& x, const std::vector<Triangle>& triangles) {
  double angle = 0.0;
  for (const auto& [i, j, k] : triangles) {
    const Vec3 a = x[i] - point, b = x[j] - point, c = x[k] - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4.0 * std::numbers::pi);
}

}  // namespace voile::geometry

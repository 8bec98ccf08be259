#include "polygon_split.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <numeric>

#include "element_parts.hpp"

namespace voile::formats {
namespace {

using Plane = CGAL::Exact_predicates_inexact_constructions_kernel;
using Corners = std::array<std::size_t, 3>;

/// Corner k of a polygon may be cut off: it is convex, and no other corner is in the triangle it makes with its
/// neighbours. `flat` are its corners in the plane, anticlockwise.
bool is_ear(const std::vector<Plane::Point_2>& flat, std::size_t k) {
  const std::size_t n = flat.size(), before = (k + n - 1) % n, after = (k + 1) % n;
  const auto &a = flat[before], &b = flat[k], &c = flat[after];
  if (CGAL::orientation(a, b, c) != CGAL::LEFT_TURN) return false;
  return std::none_of(flat.begin(), flat.end(), [&](const Plane::Point_2& p) {
    if (p == a || p == b || p == c) return false;
    return CGAL::orientation(a, b, p) != CGAL::RIGHT_TURN && CGAL::orientation(b, c, p) != CGAL::RIGHT_TURN &&
           CGAL::orientation(c, a, p) != CGAL::RIGHT_TURN;
  });
}

/// The corners projected along the coordinate axis closest to the polygon's normal, anticlockwise.
std::vector<Plane::Point_2> flattened(const std::vector<Vec3>& x) {
  Vec3 normal = Vec3::Zero();  // twice the vector area
  for (std::size_t k = 1; k + 1 < x.size(); ++k) normal += (x[k] - x[0]).cross(x[k + 1] - x[0]);
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0.0) std::swap(u, v);
  std::vector<Plane::Point_2> flat;
  for (const Vec3& p : x) flat.emplace_back(p[u], p[v]);
  return flat;
}

/// Cuts off ears until a triangle remains. A polygon that crosses itself may run out of ears; then any corner goes. A
/// convex polygon becomes a fan from its first corner.
std::vector<Corners> by_ears(const std::vector<Vec3>& x) {
  std::vector<Corners> made;
  std::vector<Plane::Point_2> flat = flattened(x);
  std::vector<std::size_t> left(x.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  while (left.size() > 3) {
    const std::size_t n = left.size();
    std::size_t k = 1;
    while (k <= n && !is_ear(flat, k % n)) ++k;
    k %= n;
    made.push_back({left[(k + n - 1) % n], left[k], left[(k + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
    flat.erase(flat.begin() + static_cast<std::ptrdiff_t>(k));
  }
  made.push_back({left[0], left[1], left[2]});
  return made;
}

}  // namespace

std::vector<Corners> split_polygon(const std::vector<Vec3>& corners) {
  if (corners.size() < 3) return {};
  if (corners.size() == 3) return {{0, 1, 2}};
  if (corners.size() != 4) return by_ears(corners);
  if (second_diagonal_is_better(corners[0], corners[1], corners[2], corners[3])) return {{1, 2, 3}, {1, 3, 0}};
  return {{0, 1, 2}, {0, 2, 3}};
}

}  // namespace voile::formats

// Tessellations of a sphere, a capsule and a cylinder.
#include "primitive_surface.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "voile/errors.hpp"

namespace voile::geometry {

namespace {

using std::numbers::pi;

void check(const char* what, double radius, int refinement, int finest) {
  if (!(radius > 0.0) || !std::isfinite(radius))
    throw InternalError(fmt::format("{}: the radius is {}, but must be positive", what, radius));
  if (refinement < 0 || refinement > finest)
    throw InternalError(fmt::format("{}: the refinement is {}, but must be from 0 to {}", what, refinement, finest));
}

/// Vertices on the unit sphere.
TriangleSoup icosahedron() {
  const double g = std::numbers::phi;
  TriangleSoup s;
  s.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                 {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  s.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Vec3& x : s.positions) x.normalize();
  return s;
}

/// Every triangle in four, with the middles of edges moved to the unit sphere.
void divide(TriangleSoup& s) {
  std::map<std::pair<Index, Index>, Index> middles;
  const auto middle = [&](Index a, Index b) {
    const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<Index>(s.positions.size()));
    if (is_new)
      s.positions.push_back(
          (s.positions[static_cast<std::size_t>(a)] + s.positions[static_cast<std::size_t>(b)]).normalized());
    return at->second;
  };
  std::vector<mesh::Triangle> fine;
  for (const auto& [a, b, c] : s.triangles) {
    const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const mesh::Triangle& t : {mesh::Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
      fine.push_back(t);
  }
  s.triangles = std::move(fine);
}

/// Circles of a surface of revolution: where on the axis [from a] and how wide, from the pole behind a to beyond b.
std::vector<Vec2> capsule_circles(double length, double radius, int n) {
  std::vector<Vec2> circles;
  for (int k = 1; k <= n / 4; ++k) {
    const double angle = 2.0 * pi * k / n;
    circles.emplace_back(-radius * std::cos(angle), radius * std::sin(angle));
  }
  if (length > 0.0) {
    circles.back()[0] = 0.0;
    circles.emplace_back(length, radius);
  }
  for (int k = n / 4 - 1; k >= 1; --k) {
    const double angle = 2.0 * pi * k / n;
    circles.emplace_back(length + radius * std::cos(angle), radius * std::sin(angle));
  }
  return circles;
}

/// A circle of a surface of revolution: where on the axis [from a], how wide, and with how many corners.
struct Circle {
  double height, radius;
  Index corners;
};

/// Width of a facet times this is the longest that a triangle of a cylinder may be.
constexpr double longest_ratio = 8.0;
constexpr double most_side_triangles = 200000.0;

/// From the middle of the end at a to that at b.
std::vector<Circle> cylinder_circles(double length, double radius, Index n) {
  const double longest = longest_ratio * 2.0 * pi * radius / n;
  const int rings = std::max(1, static_cast<int>(std::ceil(radius / longest)));
  const int most_bands = static_cast<int>(most_side_triangles) / (2 * n);
  const int bands = static_cast<int>(std::clamp(std::ceil(length / longest), 1.0, static_cast<double>(most_bands)));
  const auto ring = [&](double height, int k) {
    return Circle{height, radius * k / rings, std::max<Index>(3, n * k / rings)};
  };
  std::vector<Circle> circles;
  for (int k = 1; k < rings; ++k) circles.push_back(ring(0.0, k));
  for (int k = 0; k <= bands; ++k) circles.push_back({length * k / bands, radius, n});
  for (int k = rings - 1; k >= 1; --k) circles.push_back(ring(length, k));
  return circles;
}

/// Triangles between two circles, whose corners begin at `low` and `high`: always on to the nearer next corner.
void join_circles(Index low, Index low_count, Index high, Index high_count, std::vector<mesh::Triangle>& triangles) {
  Index i = 0, j = 0;
  while (i < low_count || j < high_count) {
    const Index p = low + i % low_count, q = high + j % high_count;
    const bool along_low = j == high_count || (i < low_count && (i + 1) * high_count <= (j + 1) * low_count);
    if (along_low)
      triangles.push_back({p, low + ++i % low_count, q});
    else
      triangles.push_back({p, high + ++j % high_count, q});
  }
}

}  // namespace

TriangleSoup sphere_surface(const Vec3& centre, double radius, int refinement) {
  check("sphere", radius, refinement, 8);
  TriangleSoup s = icosahedron();
  for (int k = 0; k < refinement; ++k) divide(s);
  for (Vec3& x : s.positions) x = centre + radius * x;
  return s;
}

TriangleSoup capsule_surface(const Vec3& a, const Vec3& b, double radius, int refinement) {
  check("capsule", radius, refinement, 7);
  const double length = (b - a).norm();
  const Vec3 axis = length > 0.0 ? Vec3((b - a) / length) : Vec3::UnitZ();
  const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
  const Index n = 8 << refinement;
  const std::vector<Vec2> circles = capsule_circles(length, radius, n);
  const auto rings = static_cast<Index>(circles.size());
  TriangleSoup s;
  for (const Vec2& c : circles)
    for (Index i = 0; i < n; ++i) {
      const double angle = 2.0 * pi * i / n;
      s.positions.emplace_back(a + c[0] * axis + c[1] * (std::cos(angle) * u + std::sin(angle) * v));
    }
  const Index first = rings * n, last = first + 1;
  s.positions.emplace_back(a - radius * axis);
  s.positions.emplace_back(a + (length + radius) * axis);
  for (Index i = 0; i < n; ++i) {
    const Index j = (i + 1) % n;
    s.triangles.push_back({first, j, i});
    for (Index k = 0; k + 1 < rings; ++k) {
      const Index p = k * n + i, q = k * n + j;
      s.triangles.push_back({p, q, q + n});
      s.triangles.push_back({p, q + n, p + n});
    }
    s.triangles.push_back({last, (rings - 1) * n + i, (rings - 1) * n + j});
  }
  return s;
}

TriangleSoup cylinder_surface(const Vec3& a, const Vec3& b, double radius, double sagitta) {
  check("cylinder", radius, 0, 0);
  const double length = (b - a).norm();
  if (!(sagitta > 0.0)) throw InternalError(fmt::format("cylinder: the sagitta is {}, but must be positive", sagitta));
  if (!(length > 0.0)) throw InternalError("cylinder: its axis has no length");
  // s = R (1 - cos(pi/n)) with corners at R; r lies in the middle between R and R cos(pi/n).
  const double needed = pi / std::acos(std::max(-1.0, (2.0 * radius - sagitta) / (2.0 * radius + sagitta)));
  const auto n = static_cast<Index>(std::ceil(std::clamp(needed, 12.0, 720.0)));
  const std::vector<Circle> circles =
      cylinder_circles(length, 2.0 * radius / (1.0 + std::cos(pi / static_cast<double>(n))), n);
  const Vec3 axis = (b - a) / length, u = axis.unitOrthogonal(), v = axis.cross(u);
  TriangleSoup s;
  s.positions = {a, b};
  std::vector<Index> first;
  for (const Circle& c : circles) {
    first.push_back(static_cast<Index>(s.positions.size()));
    for (Index i = 0; i < c.corners; ++i) {
      const double angle = 2.0 * pi * i / c.corners;
      s.positions.emplace_back(a + c.height * axis + c.radius * (std::cos(angle) * u + std::sin(angle) * v));
    }
  }
  const Circle &front = circles.front(), &back = circles.back();
  for (Index i = 0; i < front.corners; ++i)
    s.triangles.push_back({0, first.front() + (i + 1) % front.corners, first.front() + i});
  for (std::size_t k = 0; k + 1 < circles.size(); ++k)
    join_circles(first[k], circles[k].corners, first[k + 1], circles[k + 1].corners, s.triangles);
  for (Index i = 0; i < back.corners; ++i)
    s.triangles.push_back({1, first.back() + i, first.back() + (i + 1) % back.corners});
  return s;
}

}  // namespace voile::geometry

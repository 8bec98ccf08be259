// Girths by a tape, and trunks that have those asked for.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "shape.hpp"

namespace voile::manikin {

double Shape::reach(const Vec2& direction, double z) const {
  const auto at = [&](double r) { return body(Vec3(r * direction.x(), r * direction.y(), z)); };
  constexpr double close = 1e-13;  // [m]
  double inside = 0.0, outside = 0.6, low = at(inside), high = at(outside);
  // Regula falsi; what stays the same end twice counts half (Illinois).
  for (int k = 0, last = 0; k < 60 && outside - inside > close; ++k) {
    const double r = (inside * high - outside * low) / (high - low), d = at(r);
    if (std::abs(d) < close) return r;
    const int now = d < 0.0 ? -1 : 1;
    (now < 0 ? inside : outside) = r;
    (now < 0 ? low : high) = d;
    if (now == last) (now < 0 ? high : low) *= 0.5;
    last = now;
  }
  return inside;
}

double Shape::tape(double z) const {
  constexpr int rays = 180;  // on one side: a body is symmetric
  std::vector<Vec2> points;
  for (int i = 0; i <= rays; ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) / rays - 0.5);
    const Vec2 direction(std::cos(angle), std::sin(angle));
    const Vec2 point = reach(direction, z) * direction;
    points.push_back(point);
    if (i > 0 && i < rays) points.emplace_back(-point.x(), point.y());
  }
  return hull_perimeter(std::move(points));
}

Shape Shape::tuned(const Measurements& m, Kind kind) {
  constexpr double same = 1e-11;
  Shape shape(m, kind);
  const std::array asked{m.bust, m.waist, m.hip};
  const std::array at{shape.levels_.bust, shape.levels_.waist, shape.levels_.hip};
  double off = 1.0;
  for (int k = 0; k < 12 && off > same; ++k) {
    off = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double ratio = asked[i] / shape.tape(at[i]);
      shape.scale_[i] *= ratio;
      off = std::max(off, std::abs(ratio - 1.0));
    }
    shape.build();
  }
  return shape;
}

double hull_perimeter(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  std::vector<Vec2> hull;
  const auto walk = [&](const Vec2& p, std::size_t least) {
    while (hull.size() > least) {
      const Vec2 a = hull[hull.size() - 1] - hull[hull.size() - 2], b = p - hull[hull.size() - 2];
      if (a.x() * b.y() - a.y() * b.x() > 0.0) break;
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const Vec2& p : points) walk(p, 1);
  const std::size_t lower = hull.size();
  for (std::size_t i = points.size() - 1; i-- > 0;) walk(points[i], lower);
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < hull.size(); ++i) sum += (hull[i + 1] - hull[i]).norm();
  return sum;
}

}  // namespace voile::manikin

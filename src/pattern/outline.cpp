#include "outline.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "curve.hpp"

namespace voile::pattern {

namespace {

double distance(const Vec2& x, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double t = std::clamp((x - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (x - a - t * d).norm();
}

/// Whether two segments come nearer than the tolerance.
bool meet(const Vec2& a, const Vec2& b, const Vec2& p, const Vec2& q, double tolerance) {
  // Of two segments of one line the signs are those of round-off.
  const auto lie_on_both_sides = [&](const Vec2& of, const Vec2& x, const Vec2& y) {
    const double least = tolerance * of.norm(), at = cross(of, x), other = cross(of, y);
    return std::min(at, other) < -least && std::max(at, other) > least;
  };
  const Vec2 d = b - a, e = q - p;
  const bool crosses = lie_on_both_sides(d, p - a, q - a) && lie_on_both_sides(e, a - p, b - p);
  return crosses || std::min({distance(a, p, q), distance(b, p, q), distance(p, a, b), distance(q, a, b)}) <= tolerance;
}

/// A point that two segments which meet have in common.
Vec2 common_point(const Vec2& a, const Vec2& b, const Vec2& p, const Vec2& q, double tolerance) {
  for (const Vec2& x : {p, q})
    if (distance(x, a, b) <= tolerance) return x;
  for (const Vec2& x : {a, b})
    if (distance(x, p, q) <= tolerance) return x;
  return a + cross(p - a, q - p) / cross(b - a, q - p) * (b - a);
}

/// Whether the way a-b-c turns back onto itself.
bool folds_back(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 d = (a - b).normalized(), e = (c - b).normalized();
  return d.dot(e) > 0.0 && std::abs(cross(d, e)) < 1e-3;
}

}  // namespace

std::optional<Crossing> find_crossing(const Polygons& loops) {
  std::vector<Vec2> points;
  std::vector<std::size_t> next;
  for (const std::vector<Vec2>& loop : loops) {
    const std::size_t begin = points.size();
    for (std::size_t i = 0; i < loop.size(); ++i) next.push_back(begin + (i + 1) % loop.size());
    points.insert(points.end(), loop.begin(), loop.end());
  }
  const std::size_t n = points.size();
  const auto start = [&](std::size_t i) -> const Vec2& { return points[i]; };
  const auto end = [&](std::size_t i) -> const Vec2& { return points[next[i]]; };
  double length = 0.0;
  for (std::size_t i = 0; i < n; ++i) length += (end(i) - start(i)).norm();
  const double tolerance = 1e-9 * length;
  for (std::size_t i = 0; i < n; ++i)
    if (next[next[i]] != i && folds_back(start(i), end(i), end(next[i]))) return Crossing{i, next[i], end(i)};
  std::vector<std::size_t> order(n);  // by their lowest x, so that few pairs are compared
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto low = [&](std::size_t i) { return std::min(start(i)[0], end(i)[0]); };
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return low(i) < low(j); });
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = order[k];
    const double high = std::max(start(i)[0], end(i)[0]) + tolerance;
    for (std::size_t l = k + 1; l < n && low(order[l]) <= high; ++l) {
      const std::size_t j = order[l];
      if (next[i] == j || next[j] == i) continue;
      if (meet(start(i), end(i), start(j), end(j), tolerance))
        return Crossing{std::min(i, j), std::max(i, j), common_point(start(i), end(i), start(j), end(j), tolerance)};
    }
  }
  return std::nullopt;
}

bool is_inside(const std::vector<Vec2>& polygon, const Vec2& x) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i] - x, b = polygon[(i + 1) % polygon.size()] - x;
    if ((a[1] > 0.0) != (b[1] > 0.0) && (cross(a, b) > 0.0) == (b[1] > a[1])) inside = !inside;
  }
  return inside;
}

std::optional<Stray> find_stray(const Polygons& loops, std::size_t outline) {
  for (std::size_t k = 0; k < loops.size(); ++k) {
    if (k == outline) continue;
    if (!is_inside(loops[outline], loops[k].front())) return Stray{k};
    for (std::size_t other = 0; other < loops.size(); ++other)
      if (other != k && other != outline && is_inside(loops[other], loops[k].front())) return Stray{k, other};
  }
  return std::nullopt;
}

std::vector<Vec2> polygon_of(const std::vector<Curve>& curves) {
  std::vector<Vec2> points;
  for (const Curve& c : curves)
    for (int i = 0, steps = c.steps(); i < steps; ++i) points.push_back(c.at(static_cast<double>(i) / steps));
  return points;
}

Extent extent_of(const Piece& piece) {
  Extent e{piece.point(0), piece.point(0)};
  for (const Edge& edge : piece.edges)
    for (int i = 0, steps = edge.curve.steps(); i < steps; ++i) {
      const Vec2 x = edge.curve.at(static_cast<double>(i) / steps);
      e.low = e.low.cwiseMin(x);
      e.high = e.high.cwiseMax(x);
    }
  return e;
}

}  // namespace voile::pattern

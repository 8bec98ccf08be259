#include "ccd.hpp"

#include <algorithm>
#include <cmath>

namespace voile::contact {

namespace {

/// An advance keeps this fraction of the gap, and advances end when only this fraction of the first gap is left.
constexpr double kept = 0.2;
/// A gap below this fraction of the pair's size is round-off.
constexpr double no_gap = 1e-13;
/// A pair that slides along at a tiny gap stops here: what it has covered by then is safe.
constexpr int most_advances = 2000;

double speed_bound(PairKind kind, const std::array<Vec3, 4>& p) {
  switch (kind) {
    case PairKind::point_triangle:
      return p[0].norm() + std::sqrt(std::max({p[1].squaredNorm(), p[2].squaredNorm(), p[3].squaredNorm()}));
    case PairKind::point_edge:
      return p[0].norm() + std::sqrt(std::max(p[1].squaredNorm(), p[2].squaredNorm()));
    default:
      return std::sqrt(std::max(p[0].squaredNorm(), p[1].squaredNorm())) +
             std::sqrt(std::max(p[2].squaredNorm(), p[3].squaredNorm()));
  }
}

}  // namespace

Closest closest(PairKind kind, const std::array<Vec3, 4>& x) {
  switch (kind) {
    case PairKind::point_triangle:
      return point_triangle(x);
    case PairKind::point_edge:
      return point_edge(x);
    default:
      return edge_edge(x);
  }
}

double distance(PairKind kind, const std::array<Vec3, 4>& x) {
  switch (kind) {
    case PairKind::point_triangle:
      return point_triangle_distance(x);
    case PairKind::point_edge:
      return point_edge_distance(x);
    default:
      return edge_edge_distance(x);
  }
}

double axis_distance(PairKind kind, const std::array<Vec3, 4>& x) {
  const int first = kind == PairKind::edge_edge ? 2 : 1, count = kind == PairKind::point_edge ? 3 : 4;
  Vec3 low[2] = {x[0], x[first]}, high[2] = {x[0], x[first]};
  for (int i = 1; i < count; ++i) {
    Vec3 &l = low[i >= first], &h = high[i >= first];
    l = l.cwiseMin(x[i]);
    h = h.cwiseMax(x[i]);
  }
  return (low[0] - high[1]).cwiseMax(low[1] - high[0]).maxCoeff();
}

double step_fraction(PairKind kind, std::array<Vec3, 4> x, std::array<Vec3, 4> p, double xi, double limit) {
  const int count = kind == PairKind::point_edge ? 3 : 4;
  Vec3 mean = Vec3::Zero();
  for (int i = 0; i < count; ++i) mean += p[i] / count;
  for (int i = 0; i < count; ++i) p[i] -= mean;
  const double speed = speed_bound(kind, p);
  if (axis_distance(kind, x) - xi > speed * limit) return limit;
  double gap = distance(kind, x) - xi;
  double size = xi;
  for (int i = 1; i < count; ++i) size = std::max(size, (x[i] - x[0]).norm());
  if (!(gap > no_gap * size)) return 0.0;
  if (gap > speed * limit) return limit;
  const double least = kept * gap;
  double covered = 0.0;
  for (int k = 0; k < most_advances; ++k) {
    const double advance = (1.0 - kept) * gap / speed;
    if (covered + advance >= limit) return limit;
    for (int i = 0; i < count; ++i) x[i] += advance * p[i];
    gap = distance(kind, x) - xi;
    covered += advance;
    if (gap < least) return covered;
  }
  return covered;
}

}  // namespace voile::contact

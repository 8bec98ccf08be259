#include "rest_curves.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace voile::adapt {

namespace {

/// Sines of turns below this are straight: round-off of a file in double precision.
constexpr double straight = 1e-9;
/// A turn beside which another one counts as none.
constexpr double small_turn = 1e-3;
/// Distance from a curve, relative to its piece, within which a point is on it.
constexpr double on_curve = 1e-6;

/// Points of the lengths and deviations of a stretch.
constexpr int samples = 16;

double turn(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).normalized().cross((c - b).normalized()).norm();
}

/// Tangent at b of the parabola through three points, parameters as their distances.
Vec3 tangent_at_middle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double p = (b - a).norm(), q = (c - b).norm();
  return (q * (b - a) / p + p * (c - b) / q).normalized();
}

/// Tangent at a of the circle through three points: the chord a-b turned back by what the middle tangent turns on.
Vec3 tangent_at_end(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 chord = (b - a).normalized(), middle = tangent_at_middle(a, b, c);
  return (2.0 * middle.dot(chord) * chord - middle).normalized();
}

Vec3 hermite(const Vec3& a, const Vec3& b, const Vec3& ta, const Vec3& tb, double u) {
  const double l = (b - a).norm(), v = 1.0 - u;
  return v * v * (1.0 + 2.0 * u) * a + u * u * (1.0 + 2.0 * v) * b + l * (u * v * v * ta - u * u * v * tb);
}

}  // namespace

RestCurves::RestCurves(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, const Features& features) {
  const auto corner = [&](Index c) { return mesh.rest_corner(c / 3, c % 3); };
  const auto following = [&](Index h) {
    Index e = next(h);
    while (features.side_class[e] == 0) e = next(edges.twin[e]);
    return e;
  };
  std::vector<char> used(edges.twin.size(), 0);
  const auto follow = [&](Index first) {
    std::vector<Vec3> points{corner(next(first))};
    Index h = first;
    while (true) {
      used[h] = 1;
      points.push_back(corner(prev(h)));
      if (features.corner[edges.dest(h)]) break;
      h = following(h);
      if (used[h]) break;
    }
    add(std::move(points), !features.corner[edges.origin(first)]);
  };
  for (const bool from_corners : {true, false})
    for (Index h = 0; h < static_cast<Index>(edges.twin.size()); ++h)
      if (features.side_class[h] != 0 && !used[h] && (!from_corners || features.corner[edges.origin(h)])) follow(h);
  index_pieces();
}

void RestCurves::add(std::vector<Vec3> points, bool closed) {
  Curve c;
  c.closed = closed;
  const auto n = static_cast<Index>(points.size()) - 1;
  const auto at = [&](Index k) -> const Vec3& { return points[closed ? (k % n + n) % n : std::clamp(k, Index{0}, n)]; };
  std::vector<double> turns(points.size(), 0.0);
  double largest = 0.0;
  for (Index k = closed ? 0 : 1; k < (closed ? n + 1 : n); ++k) {
    turns[k] = turn(at(k - 1), at(k), at(k + 1));
    largest = std::max(largest, turns[k]);
  }
  if (largest < straight || n < 2) return;
  const auto turn_at = [&](Index k) {
    if (closed) return turns[(k % n + n) % n];
    return k <= 0 ? turns[1] : k >= n ? turns[n - 1] : turns[k];  // an end turns as its neighbour does
  };
  for (Index k = 0; k <= n; ++k) {
    const Vec3 &a = at(k - 1), &b = at(k), &d = at(k + 1);
    Vec3 before, after;
    if (!closed && k == 0) {
      before = after = tangent_at_end(b, d, at(2));
    } else if (!closed && k == n) {
      before = after = -tangent_at_end(b, a, at(n - 2));
    } else {
      const bool line_before = turn_at(k - 1) < small_turn * turns[k],
                 line_after = turn_at(k + 1) < small_turn * turns[k];
      before = after = line_before  ? Vec3((b - a).normalized())
                       : line_after ? Vec3((d - b).normalized())
                                    : tangent_at_middle(a, b, d);
      if (line_before && line_after) after = (d - b).normalized();  // a kink between straight lines
    }
    c.before.push_back(before);
    c.after.push_back(after);
  }
  c.points = std::move(points);
  curves_.push_back(std::move(c));
}

std::array<std::int64_t, 3> RestCurves::cell_of(const Vec3& x) const {
  std::array<std::int64_t, 3> c{};
  for (int d = 0; d < 3; ++d) c[d] = static_cast<std::int64_t>(std::floor(x[d] / cell_));
  return c;
}

void RestCurves::index_pieces() {
  double length = 0.0;
  std::size_t pieces = 0;
  for (const Curve& c : curves_)
    for (std::size_t k = 0; k + 1 < c.points.size(); ++k, ++pieces) length += (c.points[k + 1] - c.points[k]).norm();
  if (pieces == 0) return;
  cell_ = 2.0 * length / static_cast<double>(pieces);
  for (Index i = 0; i < static_cast<Index>(curves_.size()); ++i)
    for (Index k = 0; k + 1 < static_cast<Index>(curves_[i].points.size()); ++k) {
      const Vec3 &a = curves_[i].points[k], &b = curves_[i].points[k + 1];
      const double margin = 0.5 * (b - a).norm();
      const auto low = cell_of(a.cwiseMin(b).array() - margin), high = cell_of(a.cwiseMax(b).array() + margin);
      for (std::int64_t x = low[0]; x <= high[0]; ++x)
        for (std::int64_t y = low[1]; y <= high[1]; ++y)
          for (std::int64_t z = low[2]; z <= high[2]; ++z) grid_.push_back({{x, y, z}, {i, k}});
    }
  std::sort(grid_.begin(), grid_.end());
}

Vec3 RestCurves::point(const Place& p) const {
  const Curve& c = curves_[p.curve];
  const auto n = static_cast<Index>(c.points.size()) - 1;
  const double at = c.closed ? p.at - n * std::floor(p.at / n) : p.at;
  const Index k = std::clamp(static_cast<Index>(std::floor(at)), Index{0}, n - 1);
  return hermite(c.points[k], c.points[k + 1], c.after[k], c.before[k + 1], at - k);
}

std::vector<RestCurves::Place> RestCurves::places_of(const Vec3& x) const {
  std::vector<Place> found;
  const auto cell = cell_of(x);
  for (auto at = std::lower_bound(grid_.begin(), grid_.end(), std::pair{cell, std::array<Index, 2>{0, 0}});
       at != grid_.end() && at->first == cell; ++at) {
    const auto [i, k] = at->second;
    const Curve& c = curves_[i];
    const Vec3 &a = c.points[k], &b = c.points[k + 1];
    const double length = (b - a).norm();
    double u = std::clamp((x - a).dot(b - a) / (length * length), 0.0, 1.0);
    for (int step = 0; step < 8; ++step) {
      constexpr double du = 1e-4;
      const Vec3 here = hermite(a, b, c.after[k], c.before[k + 1], u);
      const Vec3 slope =
          (hermite(a, b, c.after[k], c.before[k + 1], u + du) - hermite(a, b, c.after[k], c.before[k + 1], u - du)) /
          (2.0 * du);
      u = std::clamp(u + (x - here).dot(slope) / slope.squaredNorm(), 0.0, 1.0);
    }
    if ((hermite(a, b, c.after[k], c.before[k + 1], u) - x).norm() > on_curve * length) continue;
    // The end of one piece is the beginning of the next.
    if (found.empty() || found.back().curve != i || std::abs(found.back().at - (k + u)) > 1e-3)
      found.push_back({i, k + u});
  }
  return found;
}

std::optional<std::array<RestCurves::Place, 2>> RestCurves::between(const Vec3& a, const Vec3& b) const {
  if (curves_.empty()) return std::nullopt;
  std::optional<std::array<Place, 2>> best;
  double shortest = std::numeric_limits<double>::infinity();
  const std::vector<Place> ends = places_of(b);
  for (const Place& p : places_of(a))
    for (Place q : ends) {
      if (p.curve != q.curve) continue;
      const Curve& c = curves_[p.curve];
      const auto n = static_cast<double>(c.points.size() - 1);
      if (c.closed) q.at -= n * std::round((q.at - p.at) / n);  // the shorter way round
      if (std::abs(q.at - p.at) >= shortest || q.at == p.at) continue;
      shortest = std::abs(q.at - p.at);
      best = {p, q};
    }
  return best;
}

std::optional<Vec3> RestCurves::middle(const Vec3& a, const Vec3& b) const {
  const auto ends = between(a, b);
  if (!ends) return std::nullopt;
  const auto [p, q] = *ends;
  std::array<double, samples + 1> length{};
  Vec3 last = a;
  for (int i = 1; i <= samples; ++i) {
    const Vec3 x = point({p.curve, p.at + (q.at - p.at) * i / samples});
    length[i] = length[i - 1] + (x - last).norm();
    last = x;
  }
  int i = 1;
  while (length[i] < 0.5 * length[samples]) ++i;
  const double fraction = (0.5 * length[samples] - length[i - 1]) / (length[i] - length[i - 1]);
  return point({p.curve, p.at + (q.at - p.at) * (i - 1 + fraction) / samples});
}

double RestCurves::deviation(const Vec3& a, const Vec3& b) const {
  const auto ends = between(a, b);
  if (!ends) return 0.0;
  const auto [p, q] = *ends;
  const Vec3 along = (b - a).normalized();
  double largest = 0.0;
  // At least four per piece: a stretch may have many.
  const int n = std::max(samples, 4 * static_cast<int>(std::ceil(std::abs(q.at - p.at))));
  for (int i = 1; i < n; ++i) {
    const Vec3 x = point({p.curve, p.at + (q.at - p.at) * i / n}) - a;
    largest = std::max(largest, (x - x.dot(along) * along).norm());
  }
  return largest;
}

}  // namespace voile::adapt

#include "chart_search.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "features.hpp"

namespace voile::adapt {

namespace {

/// Weights of the nearest point of a segment.
double along(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 e = b - a;
  return std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0);
}

}  // namespace

std::array<double, 3> nearest_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<const Vec3*, 3> x{&a, &b, &c};
  const Vec3 normal = (b - a).cross(c - a);
  const double area = normal.squaredNorm();
  std::array<double, 3> w{(b - p).cross(c - p).dot(normal) / area, (c - p).cross(a - p).dot(normal) / area, 0.0};
  w[2] = 1.0 - w[0] - w[1];
  if (w[0] >= 0.0 && w[1] >= 0.0 && w[2] >= 0.0) return w;
  double best = std::numeric_limits<double>::infinity();
  for (int s = 0; s < 3; ++s) {
    const int i = (s + 1) % 3, j = (s + 2) % 3;
    const double q = along(p, *x[i], *x[j]);
    const double d = ((1.0 - q) * *x[i] + q * *x[j] - p).squaredNorm();
    if (d >= best) continue;
    best = d;
    w[s] = 0.0;
    w[i] = 1.0 - q;
    w[j] = q;
  }
  return w;
}

ChartSearch::ChartSearch(const mesh::SurfaceMesh& mesh) : triangles_(mesh.triangles()) {
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    rest_.push_back({mesh.rest_corner(t, 0), mesh.rest_corner(t, 1), mesh.rest_corner(t, 2)});
  start_.assign(static_cast<std::size_t>(mesh.vertex_count()) + 1, 0);
  for (const mesh::Triangle& t : triangles_)
    for (Index v : t) ++start_[v + 1];
  for (Index v = 0; v < mesh.vertex_count(); ++v) start_[v + 1] += start_[v];
  of_vertex_.resize(3 * triangles_.size());
  std::vector<Index> at(start_.begin(), start_.end() - 1);
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (Index v : triangles_[t]) of_vertex_[at[v]++] = t;
  make_charts(mesh);
  make_grid();
}

void ChartSearch::make_charts(const mesh::SurfaceMesh& mesh) {
  chart_.assign(triangles_.size(), no_index);
  Index charts = 0;
  for (Index seed = 0; seed < mesh.triangle_count(); ++seed) {
    if (chart_[seed] != no_index) continue;
    std::vector<Index> members{seed};
    chart_[seed] = charts;
    for (std::size_t k = 0; k < members.size(); ++k)
      for (int s = 0; s < 3; ++s) {
        const Index n = mesh.neighbour(members[k], s);
        if (n == no_index || chart_[n] != no_index || !same_chart(mesh, members[k], s)) continue;
        chart_[n] = charts;
        members.push_back(n);
      }
    ++charts;
  }
}

void ChartSearch::make_grid() {
  low_ = rest_.front()[0];
  Vec3 high = low_;
  double edges = 0.0;
  for (const auto& corners : rest_)
    for (int i = 0; i < 3; ++i) {
      low_ = low_.cwiseMin(corners[i]);
      high = high.cwiseMax(corners[i]);
      edges += (corners[(i + 1) % 3] - corners[i]).norm();
    }
  cell_ = 2.0 * edges / (3.0 * static_cast<double>(rest_.size()));
  for (int d = 0; d < 3; ++d) cells_[d] = 1 + static_cast<std::int64_t>((high[d] - low_[d]) / cell_);
  for (Index t = 0; t < static_cast<Index>(rest_.size()); ++t) {
    const auto c = cell_of((rest_[t][0] + rest_[t][1] + rest_[t][2]) / 3.0);
    grid_.emplace_back((c[2] * cells_[1] + c[1]) * cells_[0] + c[0], t);
  }
  std::sort(grid_.begin(), grid_.end());
}

std::array<std::int64_t, 3> ChartSearch::cell_of(const Vec3& p) const {
  std::array<std::int64_t, 3> c{};
  for (int d = 0; d < 3; ++d)
    c[d] = std::clamp(static_cast<std::int64_t>(std::floor((p[d] - low_[d]) / cell_)), std::int64_t{0}, cells_[d] - 1);
  return c;
}

ChartSearch::Hit ChartSearch::hit(const Vec3& p, Index t) const {
  const auto& x = rest_[t];
  const std::array<double, 3> w = nearest_weights(p, x[0], x[1], x[2]);
  return {t, w, (w[0] * x[0] + w[1] * x[1] + w[2] * x[2] - p).squaredNorm()};
}

ChartSearch::Hit ChartSearch::nearest(const Vec3& p, Index from) const {
  Hit best = hit(p, from);
  while (true) {
    const double size = (rest_[best.triangle][1] - rest_[best.triangle][0]).squaredNorm();
    if (best.squared_distance <= 1e-24 * size) return best;
    Hit better = best;
    around(best.triangle, [&](Index t) {
      if (chart_[t] != chart_[from]) return;
      const Hit other = hit(p, t);
      // Round-off must not make it walk in circles.
      if (other.squared_distance < better.squared_distance * (1.0 - 1e-12)) better = other;
    });
    if (better.triangle == best.triangle) return best;
    best = better;
  }
}

Index ChartSearch::locate(const Vec3& p, const Vec3& normal) const {
  const auto c = cell_of(p);
  const std::int64_t farthest = std::max({cells_[0], cells_[1], cells_[2]});
  Index best = no_index;
  double distance = std::numeric_limits<double>::infinity();
  for (std::int64_t reach = 0; reach <= farthest; ++reach) {
    if (best != no_index && std::sqrt(distance) < static_cast<double>(reach - 1) * cell_) break;
    for (std::int64_t k = std::max<std::int64_t>(c[2] - reach, 0); k <= std::min(c[2] + reach, cells_[2] - 1); ++k)
      for (std::int64_t j = std::max<std::int64_t>(c[1] - reach, 0); j <= std::min(c[1] + reach, cells_[1] - 1); ++j)
        for (std::int64_t i = std::max<std::int64_t>(c[0] - reach, 0); i <= std::min(c[0] + reach, cells_[0] - 1);
             ++i) {
          if (std::max({std::abs(i - c[0]), std::abs(j - c[1]), std::abs(k - c[2])}) != reach) continue;
          const std::int64_t key = (k * cells_[1] + j) * cells_[0] + i;
          for (auto at = std::lower_bound(grid_.begin(), grid_.end(), std::pair{key, Index{0}});
               at != grid_.end() && at->first == key; ++at) {
            const auto& x = rest_[at->second];
            const double d = ((x[0] + x[1] + x[2]) / 3.0 - p).squaredNorm();
            if (d >= distance || (x[1] - x[0]).cross(x[2] - x[0]).dot(normal) <= 0.0) continue;
            distance = d;
            best = at->second;
          }
        }
  }
  return best == no_index ? 0 : best;
}

}  // namespace voile::adapt

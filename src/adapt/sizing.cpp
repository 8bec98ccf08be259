#include "sizing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>

#include "half_edges.hpp"
#include "voile/errors.hpp"

namespace voile::adapt {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// Edges of a polygon per radius: h <= R/10.
constexpr double edges_per_radius = 10.0;
/// Edges are divided by no more at once where the error asks for shorter ones.
constexpr double most_finer = 2.0;
/// Turns above this are corners, not curvature [rad].
constexpr double corner = 0.5235987755982988;

/// delta / kappa, kappa^2 averaged over the triangles of each vertex.
std::vector<double> from_curvature(const mesh::SurfaceMesh& mesh, const std::vector<double>& squared, double angle) {
  std::vector<double> sum(static_cast<std::size_t>(mesh.vertex_count()), 0.0), area = sum;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const double a = mesh.area(t);
    for (Index v : mesh.triangles()[t]) {
      sum[v] += a * squared[t];
      area[v] += a;
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] = sum[v] > 0.0 ? angle / std::sqrt(sum[v] / area[v]) : infinite;
  return sum;
}

/// R/10 on the boundary, R of the circle through three neighbours at rest; nothing at corners.
void bound_on_curved_edges(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, double smallest,
                           std::vector<double>& h) {
  for (Index side = 0; side < static_cast<Index>(edges.twin.size()); ++side) {
    if (edges.twin[side] != no_index) continue;
    Index follow = next(side);
    while (edges.twin[follow] != no_index) follow = next(edges.twin[follow]);
    const auto rest = [&](Index c) { return mesh.rest_corner(c / 3, c % 3); };
    const Vec3 a = rest(prev(side)) - rest(next(side)), b = rest(prev(follow)) - rest(next(follow));
    const double turn = std::atan2(a.cross(b).norm(), a.dot(b));
    if (turn > corner || turn < 1e-6) continue;
    const double radius = (a + b).norm() / (2.0 * std::sin(turn));
    const double bound = std::max(smallest, radius / edges_per_radius);
    h[edges.dest(side)] = std::min(h[edges.dest(side)], bound);
  }
}

/// Lowers sizes along edges until no slope is above `growth`: Dijkstra from the smallest.
void grade(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, double growth, std::vector<double>& h) {
  std::vector<Index> start(h.size() + 1, 0), sides;
  for (Index v : edges.vertex) ++start[v + 1];
  for (std::size_t v = 0; v < h.size(); ++v) start[v + 1] += start[v];
  sides.resize(edges.vertex.size());
  std::vector<Index> at(start.begin(), start.end() - 1);
  for (Index c = 0; c < static_cast<Index>(edges.vertex.size()); ++c) sides[at[edges.vertex[c]]++] = c;
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::size_t v = 0; v < h.size(); ++v) queue.emplace(h[v], static_cast<Index>(v));
  while (!queue.empty()) {
    const auto [size, v] = queue.top();
    queue.pop();
    if (size > h[v] || size == infinite) continue;
    for (Index k = start[v]; k < start[v + 1]; ++k)
      for (const Index c : {next(sides[k]), prev(sides[k])}) {
        const Index t = c / 3;
        const double length = (mesh.rest_corner(t, c % 3) - mesh.rest_corner(t, sides[k] % 3)).norm();
        double& other = h[edges.vertex[c]];
        if (other <= size + growth * length) continue;
        other = size + growth * length;
        queue.emplace(other, edges.vertex[c]);
      }
  }
}

}  // namespace

std::vector<double> size_field(const mesh::SurfaceMesh& mesh, const std::vector<Vec3>& places,
                               const std::vector<double>& curvature_squared, const std::vector<double>& bound,
                               const SizeOptions& o) {
  const auto nv = static_cast<std::size_t>(mesh.vertex_count()), nt = static_cast<std::size_t>(mesh.triangle_count());
  if (places.size() != nv || curvature_squared.size() != nt || (!bound.empty() && bound.size() != nv))
    throw InternalError("sizes: lengths of arrays do not fit the mesh");
  if (!(o.angle > 0.0) || !(o.smallest >= 0.0) || !(o.growth > 0.0) || (o.largest > 0.0 && o.largest < o.smallest))
    throw InternalError("sizes: options out of range");
  const double largest = o.largest > 0.0 ? o.largest : mesh.extent();
  const HalfEdges edges = half_edges(mesh);
  std::vector<double> h = from_curvature(mesh, curvature_squared, o.angle);
  bound_on_curved_edges(mesh, edges, o.smallest, h);
  for (std::size_t v = 0; v < nv; ++v) {
    h[v] = std::clamp(h[v], std::min(o.smallest, largest), largest);
    if (!bound.empty()) h[v] = std::min(h[v], bound[v]);
  }
  grade(mesh, edges, o.growth, h);
  return h;
}

std::vector<double> sizes_for_error(const mesh::SurfaceMesh& mesh, const std::vector<double>& density, double stored,
                                    double wanted) {
  std::vector<double> h(static_cast<std::size_t>(mesh.vertex_count()), 0.0), area = h;
  double sum = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) sum += std::sqrt(mesh.area(t) * density[t]);
  if (!(stored > 0.0) || !(sum > 0.0)) return std::vector<double>(h.size(), infinite);
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const double a = mesh.area(t), edge_squared = 4.0 * a / std::sqrt(3.0);
    const double inverse_square =
        std::min(std::sqrt(a * density[t]) * sum / (wanted * stored), most_finer * most_finer) / edge_squared;
    for (Index v : mesh.triangles()[t]) {
      h[v] += a * inverse_square;
      area[v] += a;
    }
  }
  for (std::size_t v = 0; v < h.size(); ++v) h[v] = h[v] > 0.0 ? std::sqrt(area[v] / h[v]) : infinite;
  return h;
}

SizeMatch match(const mesh::SurfaceMesh& mesh, const std::vector<double>& size, const std::vector<char>& counted) {
  if (size.size() != static_cast<std::size_t>(mesh.vertex_count()) ||
      (!counted.empty() && counted.size() != size.size()))
    throw InternalError("sizes: not one per vertex");
  const auto counts = [&](Index v) { return counted.empty() || counted[v]; };
  std::vector<double> sum(size.size(), 0.0), ratios;
  std::vector<int> edges(size.size(), 0);
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      if (mesh.neighbour(t, s) != no_index && mesh.neighbour(t, s) < t) continue;
      const mesh::Segment e{mesh.triangles()[t][(s + 1) % 3], mesh.triangles()[t][(s + 2) % 3]};
      const double ratio = 2.0 * mesh.rest_length(e) / (size[e[0]] + size[e[1]]);
      if (counts(e[0]) && counts(e[1])) ratios.push_back(ratio);
      for (Index v : e) {
        sum[v] += ratio;
        ++edges[v];
      }
    }
  SizeMatch m;
  for (std::size_t v = 0; v < size.size(); ++v) {
    if (!counts(static_cast<Index>(v))) continue;
    if (sum[v] > 1.5 * edges[v]) m.too_long += 1.0 / static_cast<double>(size.size());
    if (sum[v] < 0.5 * edges[v]) m.too_short += 1.0 / static_cast<double>(size.size());
  }
  std::tie(m.smallest, m.largest) =
      std::tuple(*std::min_element(size.begin(), size.end()), *std::max_element(size.begin(), size.end()));
  if (ratios.empty()) return m;
  std::sort(ratios.begin(), ratios.end());
  const auto percentile = [&](double p) {
    return ratios[static_cast<std::size_t>(p * static_cast<double>(ratios.size() - 1))];
  };
  m.p1 = percentile(0.01);
  m.p10 = percentile(0.1);
  m.p50 = percentile(0.5);
  m.p90 = percentile(0.9);
  m.p99 = percentile(0.99);
  return m;
}

}  // namespace voile::adapt

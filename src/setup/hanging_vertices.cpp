#include "hanging_vertices.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "geometry/closest_triangle.hpp"

namespace voile::setup {

namespace {

/// Vertices sorted along a line in no special direction, so that rows of a regular mesh do not fall together.
class Sorted {
 public:
  Sorted(const std::vector<Vec3>& x, const std::vector<Index>& vertices) {
    for (const Index v : vertices) order_.emplace_back(line().dot(x[v]), v);
    std::sort(order_.begin(), order_.end());
  }
  /// Calls f(v) for those within `tolerance` of the range of the corners.
  template <class Corners, class F>
  void each_near(const Corners& corners, double tolerance, const F& f) const {
    double low = line().dot(corners[0]), high = low;
    for (const Vec3& c : corners) {
      low = std::min(low, line().dot(c));
      high = std::max(high, line().dot(c));
    }
    for (auto at = std::lower_bound(order_.begin(), order_.end(), std::pair(low - tolerance, Index{0}));
         at != order_.end() && at->first <= high + tolerance; ++at)
      f(at->second);
  }

 private:
  static Vec3 line() { return {0.4867, 0.6314, 0.6037}; }  // not longer than 1: what is near is near along it

  std::vector<std::pair<double, Index>> order_;
};

/// Edges of a single triangle.
std::vector<mesh::Segment> boundary_edges(const mesh::MeshData& data) {
  std::vector<mesh::Segment> edges, alone;
  for (const mesh::Triangle& t : data.triangles)
    for (std::size_t s = 0; s < 3; ++s) {
      const auto [a, b] = std::minmax(t[s], t[(s + 1) % 3]);
      edges.push_back({a, b});
    }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if (end == i + 1) alone.push_back(edges[i]);
    i = end;
  }
  return alone;
}

}  // namespace

HangingVertices find_hanging(const mesh::MeshData& data, double tolerance) {
  HangingVertices found;
  if (!(tolerance > 0.0)) return found;
  const std::vector<Vec3>& x = data.positions;
  std::vector<char> used(x.size(), 0), at_rim(x.size(), 0), hangs(x.size(), 0);
  for (const mesh::Triangle& t : data.triangles)
    for (const Index v : t) used[v] = 1;
  const std::vector<mesh::Segment> edges = boundary_edges(data);
  for (const mesh::Segment& e : edges) at_rim[e[0]] = at_rim[e[1]] = 1;
  std::vector<Index> rim, all;
  for (Index v = 0; v < static_cast<Index>(x.size()); ++v) {
    if (at_rim[v]) rim.push_back(v);
    if (used[v]) all.push_back(v);
  }
  const auto at_corner = [&](Index v, const auto& corners) {
    return std::any_of(corners.begin(), corners.end(), [&](const Vec3& c) { return (x[v] - c).norm() <= tolerance; });
  };
  const Sorted at_rims(x, rim), anywhere(x, all);
  for (const mesh::Triangle& t : data.triangles) {
    const std::array corners{x[t[0]], x[t[1]], x[t[2]]};
    const Vec3 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]).array() - tolerance;
    const Vec3 high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]).array() + tolerance;
    at_rims.each_near(corners, tolerance, [&](Index v) {
      if ((x[v].array() < low.array()).any() || (x[v].array() > high.array()).any() || at_corner(v, corners)) return;
      const Vec3 w = geometry::nearest_weights(x[v], corners);
      if ((w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2] - x[v]).norm() <= tolerance) hangs[v] = 1;
    });
  }
  for (const mesh::Segment& e : edges) {
    const std::array corners{x[e[0]], x[e[1]]};
    const Vec3 along = corners[1] - corners[0];
    anywhere.each_near(corners, tolerance, [&](Index v) {
      const double s = (x[v] - corners[0]).dot(along) / along.squaredNorm();
      if (!(s > 0.0 && s < 1.0) || at_corner(v, corners)) return;
      if ((corners[0] + s * along - x[v]).norm() <= tolerance) hangs[v] = 1;
    });
  }
  for (const Index v : all)
    if (hangs[v] && found.count++ == 0) found.place = x[v];
  return found;
}

}  // namespace voile::setup

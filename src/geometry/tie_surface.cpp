#include "tie_surface.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "closest_triangle.hpp"
#include "mesh/coincident.hpp"
#include "mesh/sorted_points.hpp"

namespace voile::geometry {

namespace {

bool share_triangle(const TieSurface& s, Index v, Index w) {
  return std::any_of(s.star[v].begin(), s.star[v].end(),
                     [&](Index t) { return std::binary_search(s.star[w].begin(), s.star[w].end(), t); });
}

bool on_star(const mesh::MeshData& data, const TieSurface& s, Index v, const Vec3& x, double tolerance) {
  return std::any_of(s.star[v].begin(), s.star[v].end(),
                     [&](Index t) { return distance_to_triangle(x, corners_of(data, t)) <= tolerance; });
}

std::vector<Index> used_vertices(const TieSurface& s) {
  std::vector<Index> used;
  for (Index v = 0; v < static_cast<Index>(s.star.size()); ++v)
    if (!s.star[v].empty()) used.push_back(v);
  return used;
}

/// Vertices of one part onto near ones of another. Returns how many moved.
Index move_to_vertices(mesh::MeshData& data, double tolerance, std::vector<mesh::Segment>& rims) {
  const TieSurface s = surface_of(data, rims);
  const mesh::SortedPoints sorted(data.positions, used_vertices(s));
  std::vector<Index> rim;
  for (const mesh::Segment& e : all_rims(data, rims)) rim.insert(rim.end(), e.begin(), e.end());
  std::sort(rim.begin(), rim.end());
  rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
  std::vector<std::tuple<double, Index, Index>> pairs;
  for (const Index v : rim)
    sorted.each_near(std::array{data.positions[v]}, tie_near * s.size[v], [&](Index p) {
      const double d = (data.positions[v] - data.positions[p]).norm();
      if (d <= tolerance || d > tie_near * std::min(s.size[v], s.size[p]) || share_triangle(s, v, p)) return;
      if (on_star(data, s, p, data.positions[v], tolerance) || on_star(data, s, v, data.positions[p], tolerance))
        pairs.emplace_back(d, v, p);
    });
  std::sort(pairs.begin(), pairs.end());
  std::vector<char> taken(s.star.size(), 0);
  Index moved = 0;
  for (const auto& [d, v, p] : pairs) {
    if (taken[v] || taken[p]) continue;
    const bool other = may_move(data, s, p, data.positions[v], tolerance);
    if (!other && !may_move(data, s, v, data.positions[p], tolerance)) continue;
    taken[v] = taken[p] = 1;
    (other ? data.positions[p] : data.positions[v]) = other ? data.positions[v] : data.positions[p];
    ++moved;
  }
  if (moved > 0) mesh::merge_coincident(data, tolerance, &rims);
  return moved;
}

/// Vertices of one part onto edges of another part's rim that pass them. Returns how many moved.
Index move_to_edges(mesh::MeshData& data, double tolerance, const std::vector<mesh::Segment>& rims) {
  const TieSurface s = surface_of(data, rims);
  const mesh::SortedPoints sorted(data.positions, used_vertices(s));
  std::vector<std::tuple<double, Index, mesh::Segment>> pairs;
  for (const mesh::Segment& e : all_rims(data, rims)) {
    const Vec3 &a = data.positions[e[0]], &b = data.positions[e[1]];
    const double reach = tie_near * (b - a).norm();
    sorted.each_near(std::array{a, b}, reach, [&](Index p) {
      const Vec3& x = data.positions[p];
      const double at = station(x, a, b);
      if (!(at > 0.15 && at < 0.85)) return;
      const Vec3 y = a + at * (b - a);
      const double d = (x - y).norm();
      if (d <= tolerance || d > std::min(reach, tie_near * s.size[p]) || share_triangle(s, p, e[0]) ||
          share_triangle(s, p, e[1]))
        return;
      if (on_star(data, s, p, y, tolerance)) pairs.emplace_back(d, p, e);
    });
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<char> taken(s.star.size(), 0);
  Index moved = 0;
  for (const auto& [d, p, e] : pairs) {
    const Vec3 &a = data.positions[e[0]], &b = data.positions[e[1]];
    const Vec3 y = a + station(data.positions[p], a, b) * (b - a);
    if (taken[p] || taken[e[0]] || taken[e[1]] || !may_move(data, s, p, y, tolerance)) continue;
    taken[p] = 1;
    data.positions[p] = y;
    ++moved;
  }
  return moved;
}

/// Whether two edges at a vertex are one line: of the same curves, between as many triangles.
bool continues(const TieSurface& s, Index p, Index one, Index two) {
  const mesh::Segment a = mesh::ascending(p, one), b = mesh::ascending(p, two);
  const auto names = [&](const mesh::Segment& e) {
    const auto at = s.named.find(e);
    return at == s.named.end() ? std::vector<std::size_t>{} : at->second;
  };
  return s.around.at(a).size() == s.around.at(b).size() && names(a) == names(b);
}

}  // namespace

bool may_move(const mesh::MeshData& data, const TieSurface& s, Index p, const Vec3& y, double tolerance, Index onto) {
  if (s.fixed[p]) return false;
  const Vec3& x = data.positions[p];
  const double reach = std::max(tolerance, tie_same_shape * s.size[p]);
  bool covered = false;
  std::vector<Index> ends;
  for (const Index t : s.star[p]) {
    const mesh::Triangle& corners = data.triangles[t];
    for (const Index q : corners)
      if (q != p && s.lines.count(mesh::ascending(p, q)) > 0) ends.push_back(q);
    if (std::find(corners.begin(), corners.end(), onto) != corners.end()) continue;  // it vanishes
    std::array<Vec3, 3> c = corners_of(data, t);
    const Vec3 before = (c[1] - c[0]).cross(c[2] - c[0]);
    for (std::size_t i = 0; i < 3; ++i)
      if (corners[i] == p) c[i] = y;
    const Vec3 after = (c[1] - c[0]).cross(c[2] - c[0]);
    if (after.norm() < 0.1 * before.norm() || after.dot(before) < 0.9 * after.norm() * before.norm()) return false;
    covered = covered || distance_to_triangle(x, c) <= reach;
  }
  if (!covered || ends.empty()) return covered;
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  if (ends.size() != 2 || !continues(s, p, ends[0], ends[1])) return false;
  // Along the line, from one of its edges into the other.
  const Vec3 &one = data.positions[ends[0]], &two = data.positions[ends[1]];
  const auto slides = [&](const Vec3& behind, const Vec3& ahead) {
    return distance_to_segment(x, y, behind) <= reach && distance_to_segment(y, x, ahead) <= reach;
  };
  return slides(one, two) || slides(two, one);
}

std::array<Vec3, 3> corners_of(const mesh::MeshData& data, Index triangle) {
  const mesh::Triangle& t = data.triangles[triangle];
  return {data.positions[t[0]], data.positions[t[1]], data.positions[t[2]]};
}

double distance_to_triangle(const Vec3& p, const std::array<Vec3, 3>& corners) {
  const Vec3 w = nearest_weights(p, corners);
  return (w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2] - p).norm();
}

double station(const Vec3& p, const Vec3& a, const Vec3& b) {
  return std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  return (a + station(p, a, b) * (b - a) - p).norm();
}

std::vector<mesh::Segment> all_rims(const mesh::MeshData& data, const std::vector<mesh::Segment>& rims) {
  std::vector<mesh::Segment> all = mesh::rim_edges(data);
  all.insert(all.end(), rims.begin(), rims.end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

TieSurface surface_of(const mesh::MeshData& data, const std::vector<mesh::Segment>& rims) {
  TieSurface s;
  s.star.resize(data.positions.size());
  s.size.assign(data.positions.size(), std::numeric_limits<double>::infinity());
  s.fixed.assign(data.positions.size(), 0);
  std::vector<std::vector<std::size_t>> groups(data.triangles.size());
  for (std::size_t g = 0; g < data.groups.size(); ++g) {
    for (const Index t : data.groups[g].triangles) groups[t].push_back(g);
    for (const mesh::Segment& e : data.groups[g].segments) s.named[mesh::ascending(e[0], e[1])].push_back(g);
    if (data.groups[g].dimension == 0)
      for (const Index v : data.groups[g].vertices) s.fixed[v] = 1;
  }
  for (std::size_t t = 0; t < data.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = data.triangles[t][i], b = data.triangles[t][(i + 1) % 3];
      s.star[a].push_back(static_cast<Index>(t));
      s.around[mesh::ascending(a, b)].push_back(static_cast<Index>(t));
      const double length = (data.positions[a] - data.positions[b]).norm();
      for (const Index v : {a, b}) s.size[v] = std::min(s.size[v], length);
    }
  for (const auto& [edge, triangles] : s.around)
    if (triangles.size() != 2 || groups[triangles[0]] != groups[triangles[1]]) s.lines.insert(edge);
  for (const auto& [edge, names] : s.named) s.lines.insert(edge);
  for (const mesh::Segment& e : rims)
    if (s.around.count(e) > 0) s.lines.insert(e);
  return s;
}

Index move_to_rims(mesh::MeshData& data, double tolerance, std::vector<mesh::Segment>& rims) {
  if (!data.texture.empty()) return 0;  // coordinates would stay behind
  const Index vertices = move_to_vertices(data, tolerance, rims);
  return vertices + move_to_edges(data, tolerance, rims);
}

}  // namespace voile::geometry

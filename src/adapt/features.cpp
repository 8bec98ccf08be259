#include "features.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace voile::adapt {

namespace {

/// Kinds of lines, summed.
enum Kind : int { boundary = 1, border = 2, seam = 4, crease_line = 8, group_line = 16 };

/// Gives numbers to lists of groups (with a kind) in the order in which they are met.
template <typename Key>
class Numbering {
 public:
  int operator()(const Key& key) { return numbers_.try_emplace(key, static_cast<int>(numbers_.size())).first->second; }

 private:
  std::map<Key, int> numbers_;
};

std::vector<std::vector<int>> groups_of_triangles(const mesh::SurfaceMesh& mesh) {
  std::vector<std::vector<int>> of(static_cast<std::size_t>(mesh.triangle_count()));
  for (std::size_t g = 0; g < mesh.groups().size(); ++g)
    for (Index t : mesh.groups()[g].triangles) of[t].push_back(static_cast<int>(g));
  return of;
}

std::map<std::pair<Index, Index>, std::vector<int>> groups_of_segments(const mesh::SurfaceMesh& mesh) {
  std::map<std::pair<Index, Index>, std::vector<int>> of;
  for (std::size_t g = 0; g < mesh.groups().size(); ++g)
    for (const mesh::Segment& e : mesh.groups()[g].segments) {
      std::vector<int>& here = of[std::minmax(e[0], e[1])];
      if (here.empty() || here.back() != static_cast<int>(g)) here.push_back(static_cast<int>(g));
    }
  return of;
}

/// Vertices that groups hold by themselves: points, and members of lines and surfaces that none of their elements has.
void mark_group_points(const mesh::SurfaceMesh& mesh, Features& f) {
  f.single_vertices.clear();
  for (const mesh::Group& g : mesh.groups()) {
    std::vector<char> covered(f.corner.size(), 0);
    for (const mesh::Segment& e : g.segments) covered[e[0]] = covered[e[1]] = 1;
    for (Index t : g.triangles)
      for (Index v : mesh.triangles()[t]) covered[v] = 1;
    f.single_vertices.emplace_back();
    for (Index v : g.vertices) {
      if (covered[v]) continue;
      f.corner[v] = 1;
      f.single_vertices.back().push_back(v);
    }
  }
}

void classify_sides(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, double crease, Features& f) {
  const auto segments = groups_of_segments(mesh);
  // Which two classes of triangles a border divides is part of the line: where that changes is a corner.
  using Key = std::tuple<int, std::vector<int>, int, int>;
  Numbering<Key> number;
  number({0, {}, 0, 0});
  f.groups_of_side_class = {{}};
  f.side_class.assign(edges.twin.size(), 0);
  for (Index h = 0; h < static_cast<Index>(edges.twin.size()); ++h) {
    const Index twin = edges.twin[h];
    if (twin != no_index && twin < h) {
      f.side_class[h] = f.side_class[twin];
      continue;
    }
    int kind = twin == no_index ? boundary : 0, low = 0, high = 0;
    if (twin != no_index) {
      std::tie(low, high) = std::minmax({f.triangle_class[h / 3], f.triangle_class[twin / 3]});
      if (low != high) kind |= border;
      if (!same_chart(mesh, h / 3, h % 3))
        kind |= seam;
      else if (is_crease(mesh, h / 3, h % 3, crease))
        kind |= crease_line;
    }
    const auto found = segments.find(std::minmax(edges.origin(h), edges.dest(h)));
    std::vector<int> groups;
    if (found != segments.end()) groups = found->second;
    if (!groups.empty()) kind |= group_line;
    if (kind == 0) continue;
    const int n = number({kind, groups, low != high ? low : 0, low != high ? high : 0});
    f.side_class[h] = n;
    if (n == static_cast<int>(f.groups_of_side_class.size())) f.groups_of_side_class.push_back(groups);
  }
}

void classify_triangles(const mesh::SurfaceMesh& mesh, const Limits& limits, Features& f) {
  const auto groups = groups_of_triangles(mesh);
  Numbering<std::pair<std::vector<int>, bool>> number;
  f.triangle_class.resize(groups.size());
  for (std::size_t t = 0; t < groups.size(); ++t) {
    const bool frozen = !limits.frozen.empty() && limits.frozen[t];
    f.triangle_class[t] = number({groups[t], frozen});
    if (f.triangle_class[t] == static_cast<int>(f.groups_of_triangle_class.size()))
      f.groups_of_triangle_class.push_back(groups[t]);
  }
}

/// Rest direction of side h, in the chart of its triangle.
Vec3 direction(const mesh::SurfaceMesh& mesh, Index h) {
  return (mesh.rest_corner(prev(h) / 3, prev(h) % 3) - mesh.rest_corner(next(h) / 3, next(h) % 3)).normalized();
}

/// Turns of feature lines: from each feature side on to the next one with the same triangles to its left.
void mark_turns(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, double limit, Features& f) {
  for (Index h = 0; h < static_cast<Index>(edges.twin.size()); ++h) {
    if (f.side_class[h] == 0) continue;
    Index e = next(h);
    while (f.side_class[e] == 0) e = next(edges.twin[e]);
    if (f.side_class[e] != f.side_class[h] || direction(mesh, h).dot(direction(mesh, e)) < std::cos(limit))
      f.corner[edges.dest(h)] = 1;
  }
}

void mark_corners(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, const Limits& limits, double limit,
                  Features& f) {
  const auto nv = static_cast<std::size_t>(mesh.vertex_count());
  f.corner.assign(nv, 0);
  f.on_feature.assign(nv, 0);
  f.pinched.assign(nv, 0);
  std::vector<int> lines(nv, 0), triangles(nv, 0), seen(nv, 0);
  std::vector<Index> leaving(nv, no_index);
  for (Index h = 0; h < static_cast<Index>(edges.twin.size()); ++h) {
    ++triangles[edges.origin(h)];
    if (leaving[edges.origin(h)] == no_index) leaving[edges.origin(h)] = h;
    if (f.side_class[h] == 0 || (edges.twin[h] != no_index && edges.twin[h] < h)) continue;
    ++lines[edges.origin(h)];
    ++lines[edges.dest(h)];
  }
  for (std::size_t v = 0; v < nv; ++v) {
    const Index first = edges.first_around(leaving[v]);
    Index e = first;
    do {
      ++seen[v];
      e = edges.left(e);
    } while (e != no_index && e != first);
    f.pinched[v] = seen[v] != triangles[v];
    f.corner[v] = (lines[v] != 0 && lines[v] != 2) || f.pinched[v];
    f.on_feature[v] = lines[v] != 0;
    if (!limits.pinned.empty() && limits.pinned[v]) f.corner[v] = 1;
  }
  mark_group_points(mesh, f);
  mark_turns(mesh, edges, limit, f);
  if (limits.frozen.empty()) return;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (Index v : mesh.triangles()[t])
      if (limits.frozen[t]) f.corner[v] = 1;
}

}  // namespace

bool same_chart(const mesh::SurfaceMesh& mesh, Index t, int s) {
  if (!mesh.chart_join(t, s).same_chart) return false;
  const auto& texture = mesh.data().texture;
  if (texture.empty()) return true;
  const Index n = mesh.neighbour(t, s);
  const int sn = mesh.side_in_neighbour(t, s);
  const Vec2 &a = texture[t][(s + 1) % 3], &b = texture[t][(s + 2) % 3];
  const double apart = (texture[n][(sn + 2) % 3] - a).norm() + (texture[n][(sn + 1) % 3] - b).norm();
  // Single precision in the file passes.
  return apart <= 1e-6 * ((b - a).norm() + 1e-3 * (a.norm() + b.norm()));
}

bool is_crease(const mesh::SurfaceMesh& mesh, Index t, int s, double limit) {
  return mesh.rest_normal(t).dot(mesh.rest_normal(mesh.neighbour(t, s))) < std::cos(limit);
}

Features find_features(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, const Limits& limits, double crease) {
  Features f;
  classify_triangles(mesh, limits, f);
  classify_sides(mesh, edges, crease, f);
  mark_corners(mesh, edges, limits, crease, f);
  return f;
}

}  // namespace voile::adapt

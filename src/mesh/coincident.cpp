#include "coincident.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "sorted_points.hpp"
#include "voile/errors.hpp"

namespace voile::mesh {

namespace {

template <class T>
void sort_unique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// Calls f(v, w) for every pair of the given vertices within the tolerance.
template <class F>
void each_near_pair(const std::vector<Vec3>& x, const std::vector<Index>& vertices, double tolerance, const F& f) {
  const SortedPoints sorted(x, vertices);
  for (const Index v : vertices)
    sorted.each_near(std::array{x[v]}, tolerance, [&](Index w) {
      if (v < w && (x[v] - x[w]).norm() <= tolerance) f(v, w);
    });
}

/// Vertices on edges of a single triangle.
std::vector<Index> boundary_vertices(const MeshData& data) {
  std::vector<Index> vertices;
  for (const Segment& e : rim_edges(data)) vertices.insert(vertices.end(), e.begin(), e.end());
  sort_unique(vertices);
  return vertices;
}

/// The vertex that each one becomes: the lowest of those that hang together.
std::vector<Index> targets(const MeshData& data, double tolerance) {
  std::vector<Index> target(data.positions.size());
  std::iota(target.begin(), target.end(), Index{0});
  const auto root = [&](Index v) {
    while (target[v] != v) v = target[v] = target[target[v]];
    return v;
  };
  std::vector<Index> all(target);
  std::vector<char> at_rim(all.size(), 0);
  for (const Index v : boundary_vertices(data)) at_rim[v] = 1;
  each_near_pair(data.positions, all, tolerance, [&](Index v, Index w) {
    if (!at_rim[v] && !at_rim[w]) return;
    const Index a = root(v), b = root(w);
    target[std::max(a, b)] = std::min(a, b);
  });
  for (Index v = 0; v < static_cast<Index>(target.size()); ++v) target[v] = root(v);
  return target;
}

/// Those that have a vertex twice.
void drop_flat_triangles(MeshData& data) {
  std::vector<Index> number(data.triangles.size(), no_index);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < data.triangles.size(); ++k) {
    const Triangle t = data.triangles[k];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    number[k] = static_cast<Index>(kept);
    data.triangles[kept] = t;
    if (k < data.triangle_tags.size()) data.triangle_tags[kept] = data.triangle_tags[k];
    if (k < data.texture.size()) data.texture[kept] = data.texture[k];
    ++kept;
  }
  if (kept == data.triangles.size()) return;
  data.triangles.resize(kept);
  if (!data.triangle_tags.empty()) data.triangle_tags.resize(kept);
  if (!data.texture.empty()) data.texture.resize(kept);
  for (Group& g : data.groups) {
    for (Index& t : g.triangles) t = number[t];
    std::erase(g.triangles, no_index);
  }
}

/// Groups in the new numbers.
void renumber_groups(std::vector<Group>& groups, const std::vector<Index>& number) {
  for (Group& g : groups) {
    std::vector<Index> named = g.places();
    for (std::vector<Index>* all : {&g.vertices, &named, &g.added}) {
      for (Index& v : *all) v = number[v];
      sort_unique(*all);
    }
    std::vector<Index> added;
    std::set_difference(g.added.begin(), g.added.end(), named.begin(), named.end(), std::back_inserter(added));
    g.added = std::move(added);
    std::vector<Segment> kept;
    std::set<Segment> seen;
    for (const Segment& s : g.segments) {
      const Index a = number[s[0]], b = number[s[1]];
      if (a != b && seen.insert({std::min(a, b), std::max(a, b)}).second) kept.push_back({a, b});
    }
    g.segments = std::move(kept);
  }
}

}  // namespace

std::vector<Segment> rim_edges(const MeshData& data) {
  std::vector<Segment> edges, alone;
  for (const Triangle& t : data.triangles)
    for (std::size_t s = 0; s < 3; ++s) edges.push_back(ascending(t[s], t[(s + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if (end == i + 1) alone.push_back(edges[i]);
    i = end;
  }
  return alone;
}

double default_merge_tolerance(const MeshData& data) {
  if (data.positions.empty()) return 0.0;
  Vec3 low = data.positions.front(), high = low;
  double shortest = std::numeric_limits<double>::infinity();
  for (const Triangle& t : data.triangles)
    for (int s = 0; s < 3; ++s) {
      const Vec3 &a = data.positions[t[s]], &b = data.positions[t[(s + 1) % 3]];
      low = low.cwiseMin(a);
      high = high.cwiseMax(a);
      shortest = std::min(shortest, (b - a).norm());
    }
  return std::min(1e-6 * (high - low).norm(), 0.1 * shortest);
}

Coincidence find_coincident(const MeshData& data, double tolerance) {
  Coincidence c;
  if (!(tolerance > 0.0)) return c;
  std::vector<Index> all(data.positions.size()), lowest(all.size());
  std::iota(all.begin(), all.end(), Index{0});
  lowest = all;
  std::vector<char> alone(all.size(), 1), at_rim(all.size(), 0);
  for (const Index v : boundary_vertices(data)) at_rim[v] = 1;
  each_near_pair(data.positions, all, tolerance, [&](Index v, Index w) {
    alone[v] = alone[w] = 0;
    lowest[v] = lowest[w] = std::min(lowest[v], lowest[w]);
    if (at_rim[v] != at_rim[w] && c.joints++ == 0) c.joint = data.positions[v];
  });
  for (const Index v : all) {
    if (alone[v]) continue;
    const Vec3& x = data.positions[v];
    if (c.vertices++ == 0) c.first = c.low = c.high = x;
    c.low = c.low.cwiseMin(x);
    c.high = c.high.cwiseMax(x);
    c.places += lowest[v] == v ? 1 : 0;
  }
  return c;
}

Index merge_coincident(MeshData& data, double tolerance, std::vector<Segment>* edges) {
  if (!(tolerance > 0.0)) return 0;
  const std::vector<Index> target = targets(data, tolerance);
  for (std::size_t k = 0; k < data.triangles.size(); ++k) {
    const Triangle& t = data.triangles[k];
    if (target[t[0]] != target[t[1]] && target[t[1]] != target[t[2]] && target[t[2]] != target[t[0]]) continue;
    const Vec3& x = data.positions[target[t[0]]];
    throw UserError(fmt::format(
        "{}: mesh.merge: vertices closer than {:.4g} m become one, and then triangle {} at ({:.6g}, {:.6g}, "
        "{:.6g}) has no area; make merge_tolerance smaller than its sides",
        data.source, tolerance, k < data.triangle_tags.size() ? data.triangle_tags[k] : k + 1, x[0], x[1], x[2]));
  }
  return join_vertices(data, target, edges);
}

Index join_vertices(MeshData& data, const std::vector<Index>& target, std::vector<Segment>* edges) {
  const auto before = data.positions.size();
  std::vector<Index> number(target.size(), no_index);
  std::size_t kept = 0;
  for (std::size_t v = 0; v < target.size(); ++v) {
    if (target[v] != static_cast<Index>(v)) continue;
    number[v] = static_cast<Index>(kept);
    data.positions[kept] = data.positions[v];
    if (v < data.vertex_tags.size()) data.vertex_tags[kept] = data.vertex_tags[v];
    ++kept;
  }
  data.positions.resize(kept);
  if (!data.vertex_tags.empty()) data.vertex_tags.resize(kept);
  for (std::size_t v = 0; v < target.size(); ++v) number[v] = number[target[v]];
  for (Triangle& t : data.triangles)
    for (Index& v : t) v = number[v];
  drop_flat_triangles(data);
  renumber_groups(data.groups, number);
  if (edges) {
    for (Segment& e : *edges) e = ascending(number[e[0]], number[e[1]]);
    std::erase_if(*edges, [](const Segment& e) { return e[0] == e[1]; });
    sort_unique(*edges);
  }
  return static_cast<Index>(before - kept);
}

}  // namespace voile::mesh

#include "remesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <deque>
#include <queue>

#include "operations.hpp"
#include "output.hpp"
#include "repair.hpp"
#include "voile/errors.hpp"

namespace voile::adapt {

namespace {

/// An edge that waits, by its length when it was put in. Ties: the lower side first.
struct Waiting {
  double length;
  Index side, from, to;
};
struct ShorterFirst {
  bool operator()(const Waiting& a, const Waiting& b) const {
    return a.length != b.length ? a.length > b.length : a.side > b.side;
  }
};
struct LongerFirst {
  bool operator()(const Waiting& a, const Waiting& b) const {
    return a.length != b.length ? a.length < b.length : a.side > b.side;
  }
};
template <typename Order>
using Queue = std::priority_queue<Waiting, std::vector<Waiting>, Order>;

/// Of the shortest edges that are wanted: what is no shorter is left as it is.
constexpr double hardly_shorter = 0.98;
constexpr int relieving_sweeps = 3;

bool is_still(const Surface& s, const Waiting& w) {
  return !s.dead[w.side / 3] && s.origin(w.side) == w.from && s.dest(w.side) == w.to;
}

/// Whether halving the side would leave a needle in a triangle of which it is not the longest side. The longest is halved
/// first, if it may be; where it is frozen, halving the others would never end.
bool leaves_needle(const Surface& s, Index h) {
  constexpr double needle = 0.2;  // rad
  const double length = s.rest_length(h);
  for (const Index side : {h, s.across(h)}) {
    if (side == no_index || std::max(s.rest_length(next(side)), s.rest_length(prev(side))) <= length) continue;
    const Vec3 &apex = s.rest[side], &a = s.rest[next(side)], &b = s.rest[prev(side)], middle = 0.5 * (a + b);
    const Vec3 normal = (a - apex).cross(b - apex);
    if (std::min(smallest_angle(apex, a, middle, normal), smallest_angle(apex, middle, b, normal)) < needle)
      return true;
  }
  return false;
}

/// The side to halve first so that no needle is left at h: the longest of the triangle that would have one, and so on from
/// there (Rivara's longest-edge propagation); none where it is frozen.
Index halved_before(const Surface& s, Index h) {
  while (leaves_needle(s, h)) {
    Index longest = h;
    for (const Index side : {h, s.across(h)}) {
      if (side == no_index) continue;
      for (const Index other : {next(side), prev(side)})
        if (s.rest_length(other) > s.rest_length(longest)) longest = other;
    }
    if (s.locked(longest)) return no_index;
    h = longest;
  }
  return h;
}

void split_long(Surface& s, const Options& options) {
  Queue<LongerFirst> queue;
  const auto offer = [&](Index h) {
    const double length = s.metric_length(h);
    if (length <= options.split) return;
    if (s.locked(h))
      ++s.counts.refused_by_feature;
    else
      queue.push({length, h, s.origin(h), s.dest(h)});
  };
  for (Index h = 0; h < s.side_count(); ++h)
    if (s.is_edge(h)) offer(h);
  while (!queue.empty()) {
    const Waiting top = queue.top();
    queue.pop();
    if (!is_still(s, top)) continue;
    Index side = top.side;
    if (leaves_needle(s, side)) {
      // Otherwise flips come, and it is looked at again.
      side = options.only_splits ? halved_before(s, side) : no_index;
      if (side == no_index) continue;
      queue.push(top);
    }
    for (const Index m : s.split(side)) {
      if (m == no_index) continue;
      for (Index e : star_of(s, m).spokes) {
        offer(e);
        // Sides opposite to the new vertex have moved to other numbers; the last edge of an open star has one side only.
        offer(next(e));
        if (s.twin[prev(e)] == no_index) offer(prev(e));
      }
    }
  }
}

void collapse_short(Surface& s, const Options& options) {
  Queue<ShorterFirst> queue;
  const auto offer = [&](Index h) {
    const double length = s.metric_length(h);
    if (length < options.collapse && !s.locked(h)) queue.push({length, h, s.origin(h), s.dest(h)});
  };
  for (Index h = 0; h < s.side_count(); ++h)
    if (s.is_edge(h)) offer(h);
  while (!queue.empty()) {
    const Waiting top = queue.top();
    queue.pop();
    if (!is_still(s, top)) continue;
    const Outcome outcome = try_collapse_edge(s, top.side, options);
    count(s.counts, outcome);
    if (outcome != Outcome::done) continue;
    const Index u = s.gone[top.from] ? top.to : top.from;
    for (Index e : star_of(s, u).spokes) {
      offer(e);
      if (s.twin[prev(e)] == no_index) offer(prev(e));
    }
  }
}

/// Turns edges beside changed vertices, and those around turned ones, until the rule is met.
void flip_edges(Surface& s, const Options& options, FlipRule rule) {
  std::deque<Index> queue;
  std::vector<char> waits(static_cast<std::size_t>(s.side_count()), 0);
  const auto offer = [&](Index h) {
    const Index low = s.twin[h] == no_index ? h : std::min(h, s.twin[h]);
    if (waits[low]) return;
    waits[low] = 1;
    queue.push_back(low);
  };
  for (Index h = 0; h < s.side_count(); ++h)
    if (s.is_edge(h) && s.side_class[h] == 0 && (s.dirty[s.origin(h)] || s.dirty[s.dest(h)])) offer(h);
  // On curved surfaces the test may disagree with itself.
  const Index last = s.counts.flips + 4 * static_cast<Index>(queue.size()) + 100;
  while (!queue.empty() && s.counts.flips < last) {
    const Index h = queue.front();
    queue.pop_front();
    waits[h] = 0;
    if (s.dead[h / 3] || s.twin[h] == no_index) continue;
    const Index g = s.twin[h];
    const Outcome outcome = try_flip(s, h, options, rule);
    if (outcome != Outcome::feature) count(s.counts, outcome);
    if (outcome != Outcome::done) continue;
    for (const Index side : {h, prev(h), g, prev(g)}) offer(side);
  }
}

void smooth(Surface& s, const Options& options, int sweeps) {
  if (!options.smoothing) return;
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (Index v = 0; v < s.vertex_slots(); ++v)
      if (!s.gone[v] && s.dirty[v]) {
        const Outcome outcome = s.on_feature[v] ? try_slide(s, v, options) : try_smooth(s, v, options);
        if (outcome != Outcome::feature) count(s.counts, outcome);
      }
}

/// Vertices of triangles that are too pointed want improvement as those beside changes do.
void mark_pointed(Surface& s, const Options& options) {
  for (Index t = 0; t < s.triangle_slots(); ++t) {
    const Vec3 &a = s.rest[3 * t], &b = s.rest[3 * t + 1], &c = s.rest[3 * t + 2];
    if (smallest_angle(a, b, c, (b - a).cross(c - a)) >= options.smallest_angle) continue;
    for (Index h = 3 * t; h < 3 * t + 3; ++h) s.dirty[s.vertex[h]] = 1;
  }
}

void improve(Surface& s, const Options& options) {
  flip_edges(s, options, FlipRule::delaunay);
  smooth(s, options, 2);
  flip_edges(s, options, FlipRule::valence);
  smooth(s, options, 2);
  flip_edges(s, options, FlipRule::delaunay);
}

/// Of an edge that is too short and has stayed: one of its ends is moved, or the edge removed into its middle, or into an end although that
/// makes edges longer than `longest_after`.
void relieve(Surface& s, const Waiting& edge, const Options& options) {
  if (try_lengthen(s, edge.from, options) == Outcome::done || try_lengthen(s, edge.to, options) == Outcome::done)
    return;
  for (const Index v : {edge.from, edge.to})
    if (s.on_feature[v] && try_slide(s, v, options) == Outcome::done) return;
  if (try_merge(s, edge.side, options) == Outcome::done) return;
  Options at_last = options;
  at_last.longest_after = options.longest_at_last;
  count(s.counts, try_collapse_edge(s, edge.side, at_last));
}

/// What has moved makes room beside it, so this is done more than once. Edges that are removed leave long diagonals, which hinder the next.
void relieve_short_edges(Surface& s, const Options& options) {
  const double enough = hardly_shorter * options.shortest;
  for (int sweep = 0; sweep < relieving_sweeps; ++sweep) {
    Queue<ShorterFirst> queue;
    for (Index h = 0; h < s.side_count(); ++h)
      if (s.is_edge(h) && !s.locked(h) && s.metric_length(h) < enough)
        queue.push({s.metric_length(h), h, s.origin(h), s.dest(h)});
    for (; !queue.empty(); queue.pop())
      if (is_still(s, queue.top()) && s.metric_length(queue.top().side) < enough) relieve(s, queue.top(), options);
    flip_edges(s, options, FlipRule::delaunay);
  }
}

void check(const mesh::SurfaceMesh& mesh, const std::vector<Vec3>& places, const std::vector<double>& size,
           const Limits& limits) {
  const auto nv = static_cast<std::size_t>(mesh.vertex_count()), nt = static_cast<std::size_t>(mesh.triangle_count());
  const auto fits = [](const auto& list, std::size_t n) { return list.empty() || list.size() == n; };
  if (places.size() != nv || size.size() != nv || !fits(limits.frozen, nt) || !fits(limits.pinned, nv) ||
      !fits(limits.clearance, nv))
    throw InternalError("remeshing: lengths of arrays do not fit the mesh");
  if (!std::all_of(size.begin(), size.end(), [](double h) { return h > 0.0; }))
    throw InternalError("remeshing: wanted sizes must be positive");
}

}  // namespace

Remeshed remesh(const mesh::SurfaceMesh& mesh, const RestSurface& rest, const std::vector<Vec3>& places,
                const std::vector<double>& size, const Limits& limits, const Options& options) {
  check(mesh, places, size, limits);
  Surface s(mesh, rest, places, size, limits, options);
  mark_pointed(s, options);
  for (int round = 0; round < options.rounds; ++round) {
    const Index changes = s.counts.splits + s.counts.collapses;
    split_long(s, options);
    if (!options.only_splits) {
      collapse_short(s, options);
      improve(s, options);
    }
    ++s.counts.rounds;
    if (100 * (s.counts.splits + s.counts.collapses - changes) < s.live_vertices()) break;
  }
  if (!options.only_splits) {
    if (options.smoothing) relieve_short_edges(s, options);
    repair(s, options);
  }
  return make_output(s, mesh);
}

}  // namespace voile::adapt

#include "regions.hpp"

#include <algorithm>
#include <numeric>

namespace voile::untangle {

namespace {

/// Sets of numbers that grow together; the lowest member stands for its set.
class Sets {
 public:
  explicit Sets(Index count) : parent_(static_cast<std::size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  [[nodiscard]] Index of(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(Index i, Index j) {
    const auto [low, high] = std::minmax({of(i), of(j)});
    parent_[high] = low;
  }

 private:
  std::vector<Index> parent_;
};

using Graph = std::map<Index, std::vector<Index>>;

/// Regions that meet at a pierced edge.
Graph regions_beside(const std::vector<Index>& region, const std::set<Segment>& pierced) {
  Graph beside;
  for (const Segment& e : pierced) {
    const Index a = region[e[0]], b = region[e[1]];
    beside[a].push_back(b);
    beside[b].push_back(a);
  }
  return beside;
}

/// Sides change from one region to the next. If they cannot all do so, the first way to a region decides.
std::map<Index, int> alternate(const Graph& beside) {
  std::map<Index, int> side;
  for (const auto& [first, ignored] : beside) {
    if (!side.try_emplace(first, 0).second) continue;
    for (std::vector<Index> next{first}; !next.empty();) {
      const Index at = next.back();
      next.pop_back();
      for (const Index other : beside.at(at))
        if (side.try_emplace(other, 1 - side[at]).second) next.push_back(other);
    }
  }
  return side;
}

}  // namespace

std::vector<Index> regions_without(const Surface& surface, const std::set<Segment>& cut) {
  Sets sets(surface.sheet_points);
  for (Index e = 0; e < surface.sheet_edges; ++e) {
    const auto& [a, b] = surface.edges[e].points;
    if (cut.count({a, b}) == 0) sets.join(a, b);
  }
  std::vector<Index> region(static_cast<std::size_t>(surface.sheet_points));
  for (Index v = 0; v < surface.sheet_points; ++v) region[v] = sets.of(v);
  return region;
}

Sides sides_of(const Surface& surface, const std::set<Segment>& pierced, std::set<Segment> cut) {
  cut.insert(pierced.begin(), pierced.end());
  Sides s{regions_without(surface, cut), {}, {}, {0.0, 0.0}};
  for (Index v = 0; v < surface.sheet_points; ++v) s.areas[s.region[v]] += surface.area[v];
  s.side = alternate(regions_beside(s.region, pierced));
  for (const auto& [region, side] : s.side) s.side_areas[side] += s.areas[region];
  return s;
}

Index wrong_end(const Segment& edge, const Sides& sides) {
  const Index a = sides.region[edge[0]], b = sides.region[edge[1]];
  if (a == b) return no_index;
  const int side_a = sides.side.at(a), side_b = sides.side.at(b);
  const bool first =
      side_a == side_b ? sides.areas.at(a) < sides.areas.at(b) : sides.side_areas[side_a] < sides.side_areas[side_b];
  return first ? edge[0] : edge[1];
}

}  // namespace voile::untangle

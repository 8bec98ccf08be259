// Where the nodes of a seam lie on its two sides.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "seams.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// Corners of the two sides nearer than this fraction of a cell are taken for opposite to each other.
constexpr double opposite = 0.35;
/// Fraction of the length of a side below which two places on it are one.
constexpr double same = 1e-9;

using Pair = std::array<double, 2>;

/// Shares at which the edges of a side end, from 0 to 1.
std::vector<double> corners_of(const std::vector<Panel>& panels, const std::vector<EdgeUse>& side) {
  const double total = length_of(panels, side);
  std::vector<double> fractions{0.0};
  for (const EdgeUse& e : side)
    fractions.push_back(fractions.back() + panels[e.panel].piece.edges[e.edge].curve.length() / total);
  fractions.back() = 1.0;
  return fractions;
}

/// Corners of both sides, those of only one side not yet known on the other (negative).
std::vector<Pair> merge(const std::vector<double>& a, const std::vector<double>& b, double tolerance) {
  std::vector<Pair> all;
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const bool ends = (i == 0 && j == 0) || (i + 1 == a.size() && j + 1 == b.size());
    if (ends || (std::abs(a[i] - b[j]) < tolerance && i + 1 < a.size() && j + 1 < b.size()))
      all.push_back({a[i++], b[j++]});
    else if (a[i] < b[j] || j + 1 == b.size())
      all.push_back({a[i++], -1.0});
    else
      all.push_back({-1.0, b[j++]});
  }
  return all;
}

/// Interpolates between corners that both sides have.
void fill(std::vector<Pair>& all) {
  const auto known = [](const Pair& p) { return p[0] >= 0.0 && p[1] >= 0.0; };
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (known(all[k])) continue;
    std::size_t after = k;
    while (!known(all[after])) ++after;
    const Pair low = all[k - 1], high = all[after];
    const std::size_t own = all[k][0] >= 0.0 ? 0 : 1, other = 1 - own;
    const double f = (all[k][own] - low[own]) / (high[own] - low[own]);
    all[k][other] = low[other] + f * (high[other] - low[other]);
  }
}

/// One edge of a side of a seam, and where it begins and ends there.
struct Place {
  std::size_t seam, side;
  double begin, end;
  bool reversed;

  [[nodiscard]] bool holds(double f) const { return f > begin && f < end; }
  [[nodiscard]] double on_edge(double f) const {
    const double local = (f - begin) / (end - begin);
    return reversed ? 1.0 - local : local;
  }
  [[nodiscard]] double on_side(double local) const { return begin + (reversed ? 1.0 - local : local) * (end - begin); }
};

/// Finds the nodes of all seams. Knots are points that both sides of a seam have as nodes: corners of either, and those of a seam
/// that has an edge in common, which go from seam to seam until all agree. So do the numbers of cells between them.
class NodeFinder {
 public:
  NodeFinder(const std::vector<Panel>& panels, const std::vector<SeamLine>& seams) : panels_(panels), seams_(seams) {
    for (std::size_t k = 0; k < seams.size(); ++k) add(k);
    std::erase_if(edges_, [](const auto& entry) { return entry.second.size() < 2; });
  }

  std::vector<std::array<std::vector<double>, 2>> run() {
    repeat([&] { return carry_knots(); });
    for (std::size_t k = 0; k < seams_.size(); ++k) check_order(k);
    for (std::size_t k = 0; k < seams_.size(); ++k) count_cells(k);
    repeat([&] { return carry_cells(); });
    std::vector<std::array<std::vector<double>, 2>> all;
    for (std::size_t k = 0; k < seams_.size(); ++k) all.push_back(nodes(k));
    return all;
  }

 private:
  void add(std::size_t k) {
    const SeamLine& seam = seams_[k];
    double size = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < 2; ++s) {
      double before = 0.0;
      for (const EdgeUse& e : seam.sides[s]) {
        size = std::min(size, panels_[e.panel].size);
        const double length = panels_[e.panel].piece.edges[e.edge].curve.length();
        edges_[{e.panel, e.edge}].push_back(
            {k, s, before / seam.lengths[s], (before + length) / seam.lengths[s], e.reversed});
        before += length;
      }
    }
    sizes_.push_back(size);
    tolerances_.push_back(opposite * size / std::min(seam.lengths[0], seam.lengths[1]));
    knots_.push_back(merge(corners_of(panels_, seam.sides[0]), corners_of(panels_, seam.sides[1]), tolerances_[k]));
    fill(knots_[k]);
  }

  /// Until a pass changes nothing.
  template <class Pass>
  void repeat(const Pass& pass) const {
    constexpr int most = 100;
    for (int n = 0; n < most; ++n)
      if (!pass()) return;
    fail(edges_.begin()->second.front().seam);
  }
  void check_order(std::size_t k) const {
    for (std::size_t i = 1; i < knots_[k].size(); ++i)
      for (std::size_t s = 0; s < 2; ++s)
        if (!(knots_[k][i][s] > knots_[k][i - 1][s] + same)) fail(k);
  }
  /// Whether an edge is on side s of seam k and on side r of seam l.
  [[nodiscard]] bool share(std::size_t k, std::size_t s, std::size_t l, std::size_t r) const {
    return std::any_of(seams_[k].sides[s].begin(), seams_[k].sides[s].end(), [&](const EdgeUse& e) {
      return std::any_of(seams_[l].sides[r].begin(), seams_[l].sides[r].end(),
                         [&](const EdgeUse& f) { return e.panel == f.panel && e.edge == f.edge; });
    });
  }
  [[noreturn]] void fail(std::size_t k) const {
    for (std::size_t l = 0; l < seams_.size(); ++l)
      if (l != k && ((share(k, 0, l, 0) && share(k, 1, l, 1)) || (share(k, 0, l, 1) && share(k, 1, l, 0))))
        throw UserError(fmt::format(
            "{}: seams '{}' and '{}' sew edges of theirs to each other twice; remove one of "
            "them, or name other edges",
            panels_[seams_[k].sides[0].front().panel].file, seams_[std::min(k, l)].name, seams_[std::max(k, l)].name));
    throw UserError(
        fmt::format("{}: seam '{}': its corners and those of the seams that it has an edge in common with lie too near "
                    "to each other: let corners of the layers meet, or make the cells smaller",
                    panels_[seams_[k].sides[0].front().panel].file, seams_[k].name));
  }

  /// Calls act(from, to) for each two seams that have an edge in common.
  template <class Act>
  void for_common(const Act& act) const {
    for (const auto& entry : edges_)
      for (const Place& from : entry.second)
        for (const Place& to : entry.second)
          if (from.seam != to.seam) act(from, to);
  }

  bool carry_knots() {
    bool changed = false;
    for_common([&](const Place& from, const Place& to) {
      for (Pair& knot : knots_[from.seam])
        if (inside(from, knot[from.side])) changed = carry(from, knot, to) || changed;
    });
    return changed;
  }
  [[nodiscard]] static bool inside(const Place& p, double f) { return f > p.begin + same && f < p.end - same; }

  /// Brings a knot to another seam; one that is near to a knot of that takes its place instead.
  bool carry(const Place& from, Pair& knot, const Place& to) {
    const double f = to.on_side(from.on_edge(knot[from.side]));
    std::vector<Pair>& knots = knots_[to.seam];
    const auto after = std::find_if(knots.begin(), knots.end(), [&](const Pair& p) { return p[to.side] >= f; });
    const auto nearest = f - (*(after - 1))[to.side] < (*after)[to.side] - f ? after - 1 : after;
    const double way = std::abs((*nearest)[to.side] - f);
    if (way < same) return false;
    if (way < tolerances_[to.seam]) {
      knot[from.side] = from.on_side(to.on_edge((*nearest)[to.side]));
      return true;
    }
    const Pair low = *(after - 1), high = *after;
    Pair here{};
    here[to.side] = f;
    const std::size_t other = 1 - to.side;
    here[other] = low[other] + (f - low[to.side]) / (high[to.side] - low[to.side]) * (high[other] - low[other]);
    knots.insert(after, here);
    return true;
  }

  void count_cells(std::size_t k) {
    const SeamLine& seam = seams_[k];
    bool curved = false;
    for (const auto& side : seam.sides)
      for (const EdgeUse& e : side) curved = curved || !panels_[e.panel].piece.edges[e.edge].curve.is_line();
    std::vector<int>& cells = cells_.emplace_back();
    for (std::size_t i = 1; i < knots_[k].size(); ++i) {
      double length = 0.0;
      for (std::size_t s = 0; s < 2; ++s)
        length = std::max(length, (knots_[k][i][s] - knots_[k][i - 1][s]) * seam.lengths[s]);
      cells.push_back(std::max(curved ? least_on_curve : 1, static_cast<int>(std::ceil(length / sizes_[k] - 0.2))));
    }
  }

  bool carry_cells() {
    bool changed = false;
    for_common([&](const Place& from, const Place& to) {
      for (std::size_t i = 0; i < cells_[from.seam].size(); ++i) {
        const double middle = 0.5 * (knots_[from.seam][i][from.side] + knots_[from.seam][i + 1][from.side]);
        if (!from.holds(middle)) continue;
        const double f = to.on_side(from.on_edge(middle));
        const std::vector<Pair>& knots = knots_[to.seam];
        const auto after = std::find_if(knots.begin(), knots.end(), [&](const Pair& p) { return p[to.side] > f; });
        int& there = cells_[to.seam][static_cast<std::size_t>(after - knots.begin()) - 1];
        changed = changed || there < cells_[from.seam][i];
        there = std::max(there, cells_[from.seam][i]);
      }
    });
    return changed;
  }

  [[nodiscard]] std::array<std::vector<double>, 2> nodes(std::size_t k) const {
    std::array<std::vector<double>, 2> nodes{{{0.0}, {0.0}}};
    for (std::size_t i = 0; i < cells_[k].size(); ++i) {
      const Pair &low = knots_[k][i], &high = knots_[k][i + 1];
      const int cells = cells_[k][i];
      for (int n = 1; n <= cells; ++n)
        for (std::size_t s = 0; s < 2; ++s)
          nodes[s].push_back(n == cells ? high[s] : low[s] + (high[s] - low[s]) * n / cells);
    }
    return nodes;
  }

  const std::vector<Panel>& panels_;
  const std::vector<SeamLine>& seams_;
  std::map<std::pair<std::size_t, std::size_t>, std::vector<Place>> edges_;  ///< that are in several seams
  std::vector<double> sizes_, tolerances_;                                   ///< of each seam: [m], fraction
  std::vector<std::vector<Pair>> knots_;
  std::vector<std::vector<int>> cells_;  ///< between them
};

}  // namespace

std::vector<std::array<std::vector<double>, 2>> seam_nodes(const std::vector<Panel>& panels,
                                                           const std::vector<SeamLine>& seams) {
  return NodeFinder(panels, seams).run();
}

}  // namespace voile::pattern

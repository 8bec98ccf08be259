// Where the nodes of a seam lie on its two sides.
#include <algorithm>
#include <cmath>

#include "seams.hpp"

namespace voile::pattern {

namespace {

/// Corners of the two sides nearer than this fraction of a cell are taken for opposite to each other.
constexpr double opposite = 0.35;

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

}  // namespace

std::array<std::vector<double>, 2> seam_nodes(const std::vector<Panel>& panels, const SeamLine& seam) {
  double size = std::numeric_limits<double>::infinity();
  bool curved = false;
  for (const auto& side : seam.sides)
    for (const EdgeUse& e : side) {
      size = std::min(size, panels[e.panel].size);
      curved = curved || !panels[e.panel].piece.edges[e.edge].curve.is_line();
    }
  const double shorter = std::min(seam.lengths[0], seam.lengths[1]);
  std::vector<Pair> corners =
      merge(corners_of(panels, seam.sides[0]), corners_of(panels, seam.sides[1]), opposite * size / shorter);
  fill(corners);
  std::array<std::vector<double>, 2> nodes{{{0.0}, {0.0}}};
  for (std::size_t k = 1; k < corners.size(); ++k) {
    double length = 0.0;
    for (std::size_t s = 0; s < 2; ++s)
      length = std::max(length, (corners[k][s] - corners[k - 1][s]) * seam.lengths[s]);
    const int least = curved ? least_on_curve : 1;
    const int cells = std::max(least, static_cast<int>(std::ceil(length / size - 0.2)));
    for (int i = 1; i <= cells; ++i)
      for (std::size_t s = 0; s < 2; ++s)
        nodes[s].push_back(i == cells ? corners[k][s]
                                      : corners[k - 1][s] + (corners[k][s] - corners[k - 1][s]) * i / cells);
  }
  return nodes;
}

}  // namespace voile::pattern

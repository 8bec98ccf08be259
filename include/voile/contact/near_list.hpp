// Of many candidates the few that can matter: their gaps at some positions, and how far points have gone since.
//
// Symbols   g_ref  gap of a pair when the list was made [m];  m_i  how far point i is from where it was then [m]
// The gap of a pair is now at least g_ref - max m_i of one figure - max m_i of the other. The list holds the pairs with
// g_ref below a reach; it answers for gaps up to the reach less twice the largest m_i. Nothing here communicates.
#pragma once

#include <functional>
#include <vector>

#include "voile/contact/broad_phase.hpp"

namespace voile::contact {

class NearList {
 public:
  /// Makes the list of all pairs with a gap below `reach` at positions x. `offset(pair)`: what the distance of its
  /// figures exceeds its gap by. [m]
  void make(const std::vector<Pair>& pairs, const std::vector<Vec3>& x, double reach,
            const std::function<double(const Pair&)>& offset);
  /// The pairs have changed.
  void forget() { made_ = false; }
  [[nodiscard]] bool made() const { return made_; }

  /// How far points have gone since the list was made; keeps its memory from one measurement to the next.
  struct Moves {
    std::vector<double> of_point;  ///< m_i, right for measured points [m]
    double most = 0.0;             ///< of them [m]
  };
  /// m_i of `points` at positions x. [m]
  void measure(const std::vector<Index>& points, const std::vector<Vec3>& x, Moves& moves) const;
  /// The same, with twice the displacement from there to `to` added. [m]
  void measure(const std::vector<Index>& points, const std::vector<Vec3>& x, const std::vector<Vec3>& to,
               Moves& moves) const;
  /// Whether no pair with a gap below `limit` is missing where points have moved so far.
  [[nodiscard]] bool holds(const Moves& moves, double limit) const {
    return made() && limit + 2.0 * moves.most <= reach_;
  }
  /// Calls f(pair) for every listed pair whose gap may be below `limit`, in the order of `pairs`.
  template <class F>
  void for_each(const std::vector<Pair>& pairs, const Moves& moves, double limit, F&& f) const {
    for (const Entry& e : entries_) {
      const Pair& p = pairs[e.pair];
      if (e.gap - displacement(p, moves.of_point) < limit) f(p);
    }
  }

 private:
  struct Entry {
    std::size_t pair;
    double gap;
  };
  [[nodiscard]] static double displacement(const Pair& p, const std::vector<double>& m) {
    const double first = m[p.points[0]], second = m[p.points[1]], third = m[p.points[2]];
    if (p.kind == PairKind::edge_edge) return std::max(first, second) + std::max(third, m[p.points[3]]);
    const double last = p.kind == PairKind::point_edge ? 0.0 : m[p.points[3]];
    return first + std::max({second, third, last});
  }

  bool made_ = false;
  std::vector<Vec3> reference_;  ///< all points
  std::vector<Entry> entries_;
  double reach_ = 0.0;
};

}  // namespace voile::contact

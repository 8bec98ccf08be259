// Of many candidates the few that can matter: their gaps at reference positions, and how far points have gone from there.
//
// Symbols   g_ref  gap of a pair with all points at their references [m];  m_i  how far point i is from its reference, or
//                  may go from there [m];  a_i  how far it may go before the list has to be renewed for it [m]
// The gap of a pair is now at least g_ref - max m_i of one figure - max m_i of the other. The list holds the pairs with
// g_ref below a limit + max a_i + max a_i: it answers for gaps up to that limit as long as no m_i exceeds its a_i. A point
// that goes far is given another reference and more room, without the rest of the list. Nothing here communicates.
// Source: L. Verlet, Phys. Rev. 159 (1967) 98-103.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "broad_phase.hpp"

namespace voile::contact {

class NearList {
 public:
  /// It will answer for gaps up to `limit`; points that hardly move have so much room. [m]
  NearList(double limit, double room) : limit_(limit), room_(room) {}

  /// What the distance of a pair's figures exceeds its gap by. [m]
  using Offset = std::function<double(const Pair&)>;
  /// Makes the list hold, unless one of them goes too far for that, while `points`, all that pairs may have, go from `from` to `to`. `changed`: per point, whether
  /// pairs that have it may be others than at the last call; none: all of them.
  void renew(const std::vector<Pair>& pairs, const std::vector<Index>& points, const std::vector<Vec3>& from,
             const std::vector<Vec3>& to, const std::vector<char>* changed, const Offset& offset);
  /// The pairs are others.
  void forget() { made_ = false; }
  [[nodiscard]] bool made() const { return made_; }

  /// How far points have gone; keeps its memory from one measurement to the next.
  struct Moves {
    std::vector<double> of_point;  ///< m_i, right for measured points [m]
    bool within = false;           ///< whether none exceeds a_i
  };
  /// m_i of `points` at positions x. [m]
  void measure(const std::vector<Index>& points, const std::vector<Vec3>& x, Moves& moves) const;
  /// The same, with twice the displacement from there to `to` added. [m]
  void measure(const std::vector<Index>& points, const std::vector<Vec3>& x, const std::vector<Vec3>& to,
               Moves& moves) const;
  /// Whether no pair with a gap below `limit` is missing where points have moved so far.
  [[nodiscard]] bool holds(const Moves& moves, double limit) const { return made() && limit <= limit_ && moves.within; }
  /// Calls f(pair) for every listed pair whose gap may be below `limit`, in ascending order.
  template <class F>
  void for_each(const Moves& moves, double limit, F&& f) const {
    for (const Entry& e : entries_)
      if (e.gap - of_both(e.pair, moves.of_point) < limit) f(e.pair);
  }

 private:
  struct Entry {
    Pair pair;
    double gap;  ///< g_ref
  };
  /// Largest value of the points of either figure, added.
  [[nodiscard]] static double of_both(const Pair& p, const std::vector<double>& m) {
    const double first = m[p.points[0]], second = m[p.points[1]], third = m[p.points[2]];
    if (p.kind == PairKind::edge_edge) return std::max(first, second) + std::max(third, m[p.points[3]]);
    const double last = p.kind == PairKind::point_edge ? 0.0 : m[p.points[3]];
    return first + std::max({second, third, last});
  }
  [[nodiscard]] double room_for(double coming) const;
  /// Too far for any list.
  [[nodiscard]] bool goes_far(const std::vector<Index>& points, const std::vector<Vec3>& from,
                              const std::vector<Vec3>& to) const;
  /// Which points need another reference; false if none does.
  [[nodiscard]] bool find_stale(const std::vector<Index>& points, const std::vector<Vec3>& from,
                                const std::vector<Vec3>& to, const std::vector<char>* changed);
  [[nodiscard]] bool is_stale(const Pair& p) const {
    return stale_[p.points[0]] || stale_[p.points[1]] || stale_[p.points[2]] ||
           (p.points[3] != no_index && stale_[p.points[3]]);
  }

  double limit_, room_;
  bool made_ = false;
  std::vector<Vec3> reference_;  ///< all points
  std::vector<double> allowed_;  ///< a_i
  std::vector<char> stale_;
  std::vector<Entry> entries_;  ///< ascending
};

}  // namespace voile::contact

// Gaps between a sheet and all that it may touch, by the distance of pairs; private to src/untangle.
//
// Symbols   w, c_i   vector between the closest points of a pair and their weights (contact/distance.hpp)
//           g        = |w| - offset, or n.x_i - level - offset for a plane: the gap [m]
#pragma once

#include <vector>

#include "tangle.hpp"

namespace voile::untangle {

/// Fraction of the activation distance: smaller gaps are widened, so that no barrier acts at the start.
inline constexpr double least_gap = 1.0;

class Gaps {
 public:
  Gaps(Tangle& tangle, const std::vector<Plane>& planes);

  /// Widens gaps that are too small: those of pairs with planes, balls and capsules, whose distance tells inside from
  /// outside, or all.
  void widen(bool all);
  /// Infinite: none is below the activation distance. That of neighbours (neighbours.hpp) counts over its fraction. [m]
  [[nodiscard]] double smallest() const;

 private:
  [[nodiscard]] std::vector<Pair> near_pairs() const;
  void widen_planes();
  void widen_pair(const Pair& pair);
  [[nodiscard]] Closest closest_of(const Pair& pair) const;
  [[nodiscard]] double plane_gap(const Plane& p, Index i) const;
  [[nodiscard]] bool plane_acts(const Plane& p, Index i) const;
  [[nodiscard]] bool tells_inside(const Pair& p) const { return !has_faces_[p.body_a] || !has_faces_[p.body_b]; }

  Tangle& tangle_;
  const std::vector<Plane>& planes_;
  double least_, wanted_;        ///< [m]
  std::vector<char> has_faces_;  ///< by body
};

}  // namespace voile::untangle

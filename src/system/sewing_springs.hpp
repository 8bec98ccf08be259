// Springs that pull the two sides of open seams together.
//
// Symbols   L_k   distance of a pair of points at the start;  l_k its fraction of the seam's length                   [m]
//           v     closing speed [m/s],  t_0 start [s]
//   rest length  max(0, L_k - v (t - t_0)),   stiffness k l_k, doubling again and again once all rest lengths are 0
//   largest force T l_k, doubling likewise, up to T_max l_k: seams that are closed do not notice
//   s_k   station of a pair along a seam that a slider closes at the speed V: it takes t - s_k / V for t, and no spring pulls before
// Theory: docs/theory/contact.md, sewing.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "conditions.hpp"

namespace voile::energy {
class SeamTerm;
struct Configuration;
}  // namespace voile::energy

namespace voile::system {

class Discretisation;

class SewingSprings {
 public:
  /// Adds its elements to `term`, which must outlive it. Not collective. Throws UserError for unknown seams.
  SewingSprings(const Discretisation& on, Sewing sewing, energy::SeamTerm& term);
  /// Sets rest lengths and stiffnesses at a time, on which alone they depend, so that a restart needs no memory. Not
  /// collective.
  void tighten(double time);
  /// What fraction of the way gathers have gone at a time, 1 when no spring has a length any more. The same on every rank.
  [[nodiscard]] double drawn_in(double time) const;
  /// Largest force per length with which springs pull at a time [N/m]. The same on every rank.
  [[nodiscard]] double largest_force(double time) const;
  /// Whether it rises from that time on.
  [[nodiscard]] bool rises(double time) const { return largest_force(time) < sewing_.most_force; }
  /// What a step has to resolve at the time in force, or closed springs pull now too much, now too little; infinite before
  /// they are closed. The same on every rank. [m]
  [[nodiscard]] double resolution() const { return resolution_; }
  /// Force per length with which the springs of each seam pull in this state: mean along it and largest [N/m]. Collective.
  struct Pull {
    std::string seam;
    double mean, largest;
  };
  [[nodiscard]] std::vector<Pull> pulls(const energy::Configuration& c) const;
  /// When the last slider of a zipper gets to its end; 0: there is none. [s]
  [[nodiscard]] double zipped_at() const { return zipped_after_ > 0.0 ? sewing_.start + zipped_after_ : 0.0; }

 private:
  struct Spring {
    double length, stiffness;  ///< at the start [m], [N/m]
    double part;               ///< l_k
    bool gathered;
    double delay = 0.0;  ///< until a slider has come to it [s]
    std::size_t seam = 0;
  };
  /// Until gathers are drawn in, and until no spring has a length any more. [s]
  [[nodiscard]] double drawing_time() const;
  [[nodiscard]] double closing_time() const;

  const Discretisation* on_;
  Sewing sewing_;
  energy::SeamTerm* term_;
  std::vector<Spring> springs_;  ///< of its elements
  struct Seam {
    std::string name;
    double length;  ///< [m]
  };
  std::vector<Seam> seams_;  ///< the same on every rank
  bool gathers_ = false;     ///< whether any seam is gathered; the same on every rank
  double resolution_ = std::numeric_limits<double>::infinity();
  double zipped_after_ = 0.0;      ///< time that sliders take [s]
  double longest_distance_ = 0.0;  ///< of points that are sewn together, at the start [m]
};

}  // namespace voile::system

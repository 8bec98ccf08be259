// Elastic bands along curves, which may get shorter in time.
//
// Symbols   L_e   length of an edge at rest [m];  c  length of the band over that of its curve at rest
//           EA    stiffness [N];  T  time of rise, t_0 start [s];  s = clamp((t - t_0)/T, 0, 1)
//   length without force  L = L_e (1 + s (c - 1)),  stiffness EA/L;  a band that is not shorter than its curve has s = 1
#pragma once

#include <vector>

#include "conditions.hpp"

namespace voile::energy {
class SpringTerm;
}  // namespace voile::energy

namespace voile::system {

class Discretisation;

class Bands {
 public:
  /// `term` gets the elements and must outlive it.
  Bands(const Discretisation& on, energy::SpringTerm& term) : on_(on), term_(&term) {}
  /// At its final length. Not collective. Throws UserError for a length that no band has.
  void add(const Spring& spring);
  /// Sets lengths at a time, on which alone they depend, so that a restart needs no memory. Not collective.
  void tighten(double time);
  /// Whether lengths depend on the time; the same on every rank.
  [[nodiscard]] bool rise() const { return rise_; }

 private:
  struct Edge {
    Index element;
    double rest, fraction, stiffness, start, rise;
  };
  const Discretisation& on_;
  energy::SpringTerm* term_;
  std::vector<Edge> edges_;  ///< of bands that rise
  bool rise_ = false;
};

}  // namespace voile::system

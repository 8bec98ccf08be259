// What became of a motion's energy, in words.
#pragma once

#include <string>

#include "solve/time_options.hpp"
#include "system/energy_balance.hpp"

namespace voile::record {

/// Of the states that a run has recorded [J, s].
struct KineticEnergy {
  double last = 0.0, largest = 0.0, time_of_largest = 0.0;
  void add(double time, double value) {
    last = value;
    if (!(value > largest)) return;
    largest = value;
    time_of_largest = time;
  }
  /// Below a millionth of the largest, which is a thousandth of its velocities.
  [[nodiscard]] bool at_rest() const { return largest > 0.0 && last < 1e-6 * largest; }
};

/// One line each for the end of a run; the last one is empty if nothing has moved. Up to `round_off` [J] nothing is amiss.
[[nodiscard]] std::string balance_text(const system::EnergyBalance& balance, double round_off);
/// What to do if much of the energy is not accounted for, else empty. `round_off`: energy that is none [J].
[[nodiscard]] std::string balance_warning(const system::EnergyBalance& balance, const solve::TimeOptions& options,
                                          double round_off = 0.0);
/// The same where the time stepping has created energy.
[[nodiscard]] std::string creation_warning(const system::EnergyBalance& balance, double round_off);
[[nodiscard]] std::string rest_text(const KineticEnergy& kinetic);

}  // namespace voile::record

// A damped fall until the sheet nearly rests, before the search for an equilibrium with contact; private to src/solve.
//
// Symbols   c cell: square root of the mean area of a triangle;  g root mean square of the acceleration by the loads
//           T = sqrt(2 c/g): time in which a free sheet falls by one cell
// Motion by backward differences (spectral radius 0) in steps up to T, whose velocities are set to zero whenever the
// kinetic energy falls: kinetic damping, which needs no coefficient. The path does not depend on a
// uniform mass, only the time does, so that sheets without a mass get one. A sheet that moves by less than a fraction of a
// cell per T when the kinetic energy has its peak is left to Newton.
// Source: M. R. Barnes, Int. J. Space Struct. 14 (1999) 89-104.
#pragma once

#include <string>

#include "stepper.hpp"

namespace voile::solve {

struct FallResult {
  bool rested = false;   ///< false: `reason` says why
  bool endless = false;  ///< it has flown far away: nothing holds it
  int steps = 0, iterations = 0, factorisations = 0;
  std::string reason;
};

/// Lets the sheet fall from and into `state.u` at the model's load factor, until its peaks of speed are below
/// `rest_speed` cells per T. Supports must be where they are prescribed. Collective. `remark` is called on every rank
/// now and then. Throws Interrupted after a signal.
[[nodiscard]] FallResult fall_to_rest(system::Model& model, system::State& state, double rest_speed, int max_iterations,
                                      const Stepper::Remark& remark);

}  // namespace voile::solve

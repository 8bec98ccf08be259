// When an equilibrium iteration has converged.
//
// Symbols   r residual, f scale of forces (Model::force_scale), dx increment, x - x0 change since the start of the step
// Converged:  |r| <= rtol f and |dx| <= stol |x - x0|   (-snes_rtol, -snes_stol; also |r| <= -snes_atol), or, where
//             the residual has reached its round-off, |dx| <= stol/1000 |x - x0| and |r.dx| <= rtol/1000 f |x - x0|,
//             or |r| <= eps |A| |X| sqrt(unknowns) (A membrane stiffness) and no longer falling,
//             or |dx| <= eps |X| sqrt(unknowns) and |r| no longer falling: what rests for a moment on stiff contact.
#pragma once

#include <petscsnes.h>

#include "voile/system/model.hpp"

namespace voile::solve {

/// What is known after an iteration.
struct Progress {
  double residual = 0.0;         ///< |r| [N]
  double residual_before = 0.0;  ///< of the iteration before [N]
  double force = 0.0;            ///< f [N]
  double increment = 0.0;        ///< |dx| [m]
  double step = 0.0;             ///< |x - x0| [m]
  double work = 0.0;             ///< r.dx [J]
};

class ConvergenceTest {
 public:
  explicit ConvergenceTest(const system::Model& model);
  /// Takes the tolerances in force from the SNES.
  void read(SNES snes);
  /// Which criterion is met; SNES_CONVERGED_ITERATING if none.
  [[nodiscard]] SNESConvergedReason judge(const Progress& p) const;
  /// True if a state is in equilibrium by far before anything was done.
  [[nodiscard]] bool nothing_to_do(double residual, double force) const;
  /// True if an increment cannot be right.
  [[nodiscard]] bool is_wild(double increment) const { return !(increment <= wild_); }
  /// True if an increment is nearly as small as the last one has to be.
  [[nodiscard]] bool is_small(double increment, double step) const { return increment <= 2.0 * stol_ * step; }
  [[nodiscard]] int max_iterations() const { return max_iterations_; }

 private:
  double atol_ = 0.0, rtol_ = 0.0, stol_ = 0.0;
  int max_iterations_ = 0;
  double position_round_off_;  ///< norm of an increment that positions cannot resolve [m]
  double round_off_;           ///< norm of the residual that the round-off of positions alone can leave [N]
  double wild_;                ///< [m]
};

}  // namespace voile::solve

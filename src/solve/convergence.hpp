// When an equilibrium iteration has converged.
//
// Symbols   r residual, f scale of forces (Model::force_scale), dx increment, x - x0 change since the start of the step
// Converged:  |r| <= rtol f and |dx| <= stol |x - x0|   (-snes_rtol, -snes_stol; also |r| <= -snes_atol
//             up to f/1000), or, where
//             the residual has reached its round-off, |dx| <= stol/1000 |x - x0| and |r.dx| <= rtol/1000 f |x - x0|,
//             or |r| <= eps |A| |X| sqrt(unknowns) (A membrane stiffness) and no longer falling,
//             or |dx| <= eps |X| sqrt(unknowns) and |r| no longer falling: what rests for a moment on stiff contact.
// Where dx is not the full increment of Newton's method (the user's choice of SNES, line search or linear solver), it does
// not bound the distance to the solution, and only the residual counts.
// Why so: docs/developers/decisions/own-convergence.md; theory: docs/theory/path-following.md.
#pragma once

#include <petscsnes.h>

#include <string>

#include "system/model.hpp"

namespace voile::solve {

/// What is known after an iteration.
struct Progress {
  double residual = 0.0;         ///< |r| [N]
  double residual_before = 0.0;  ///< of the iteration before [N]
  double force = 0.0;            ///< f [N]
  double increment = 0.0;        ///< |dx| [m]
  double step = 0.0;             ///< |x - x0| [m]
  double work = 0.0;             ///< r.dx [J]
  bool is_newton = true;         ///< dx is the full increment of Newton's method
};

/// "1.2e-05 of the forces"; where forces have reached their round-off there is nothing to compare a residual with.
[[nodiscard]] std::string part_of_forces(double residual);

class ConvergenceTest {
 public:
  explicit ConvergenceTest(const system::Model& model);
  /// Takes the tolerances in force from the SNES. Throws UserError if what they allow is no equilibrium.
  void read(SNES snes);
  /// Which criterion is met; SNES_CONVERGED_ITERATING if none.
  [[nodiscard]] SNESConvergedReason judge(const Progress& p) const;
  /// True if a state is in equilibrium by far before anything was done.
  [[nodiscard]] bool nothing_to_do(double residual, double force) const;
  /// True if forces are in balance to the tolerance or to their round-off.
  [[nodiscard]] bool is_balanced(double residual, double force) const;
  /// Norm of the residual that round-off of the positions can leave [N].
  [[nodiscard]] double round_off() const { return round_off_; }
  /// From now on positions may be as far away as in state a: their round-off grows with it. Collective.
  void see(Vec a);
  /// True if an increment cannot be right.
  [[nodiscard]] bool is_wild(double increment) const { return !(increment <= wild_); }
  /// True if an increment is nearly as small as the last one has to be.
  [[nodiscard]] bool is_small(double increment, double step) const { return increment <= 2.0 * stol_ * step; }
  [[nodiscard]] int max_iterations() const { return max_iterations_; }

 private:
  void set_round_off(double distance);
  /// Largest residual of an equilibrium [N]; -snes_atol counts up to a small part of the forces.
  [[nodiscard]] double allowed(double force) const;

  double atol_ = 0.0, rtol_ = 0.0, stol_ = 0.0;
  int max_iterations_ = 0;
  double distance_;    ///< of the farthest vertex from the origin, at the start [m]
  double resolution_;  ///< norm of an increment that cannot be resolved per that distance
  double stiffness_;   ///< of a cell [N/m]
  double position_round_off_ = 0.0, round_off_ = 0.0;  ///< norms of increments [m] and residuals [N] below round-off
  double wild_;                                        ///< [m]
};

}  // namespace voile::solve

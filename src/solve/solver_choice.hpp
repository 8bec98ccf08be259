// What the user's options made of a SNES, and whether its increments are Newton's; private to src/solve.
//
// An increment tells how far the solution is only if it solves the linear system, with the tangent of its own state
// (Dennis & Schnabel, Numerical Methods for Unconstrained Optimization, 1996, section 7.2). What other methods reach is
// judged by the residual alone.
#pragma once

#include <petscsnes.h>

namespace voile::solve {

/// Before a SNES reads its options: throws UserError for those that cannot work. Not collective.
void refuse_snes_options();

class SolverChoice {
 public:
  /// Reads what a SNES is after its options. With `contact`, only methods whose steps our bound controls are taken.
  /// Collective. Throws UserError for what cannot work.
  void read(SNES snes, bool contact);
  /// The method is Newton's with a tangent of every state: its full increments count.
  [[nodiscard]] bool is_newton() const { return newton_; }
  /// The preconditioner is computed anew for every tangent.
  [[nodiscard]] bool is_current() const { return current_; }

 private:
  bool newton_ = true, current_ = true;
};

}  // namespace voile::solve

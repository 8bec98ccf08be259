// Modes of vibration and of linear buckling about an equilibrium, through SLEPc's EPS.
//
// Symbols     K exact tangent at the equilibrium (a, lambda);  M mass, consistent or lumped;
//             x_f = K^-1 f, f = -dr/dlambda
// Vibration   K phi = omega^2 M phi;  frequency = omega/(2 pi), from the smallest omega^2 up (negative: unstable, then
//             the frequency is given as negative: -sqrt(-omega^2)/(2 pi))
// Buckling    (K + mu K') phi = 0,  K' = d/dmu K(a + mu x_f, lambda + mu),  critical load factor lambda + mu, from the
//             smallest mu > 0 up; solved as -K' phi = (1/mu) K phi, so that only K is factored. K' is a central
//             difference, exact but for round-off where K is quadratic in a (membrane) or constant (bending of a flat
//             rest shape).
// About an unstable state vibration finds the modes nearest to omega^2 = 0, not the most negative ones.
// Fixed components are left out: zero rows in M and K'.
// Options of SLEPc's EPS and ST work as users know them: -eps_nev, -eps_tol, -eps_monitor, -eps_view, -st_type ...
#pragma once

#include <vector>

#include "newton.hpp"
#include "system/dynamics.hpp"

namespace voile::solve {

struct Mode {
  double eigenvalue = 0.0;  ///< omega^2 [1/s^2], or 1/mu
  double value = 0.0;       ///< frequency [Hz], or critical load factor
  double residual = 0.0;    ///< backward error: |A x - theta B x| / ((|A| + |theta| |B|) |x|)
  petsc::VecHandle shape;   ///< unknowns, largest component of the displacement 1
};

struct EigenResult {
  std::vector<Mode> modes;
  int asked_for = 0;  ///< options may ask for another number than the caller
};

/// Lowest `count` modes of vibration about `a` at the model's load factor. Collective.
/// Throws UserError if a material has no mass.
[[nodiscard]] EigenResult vibration_modes(system::Model& model, Vec a, int count, system::Mass mass);
/// Lowest `count` critical load factors beyond the model's load factor. Collective.
/// Throws UserError if the equilibrium is unstable or no load grows with the load factor.
[[nodiscard]] EigenResult buckling_modes(Newton& newton, system::Model& model, Vec a, int count);

/// SLEPc between construction and destruction; PETSc must be running.
class SlepcSession {
 public:
  SlepcSession();
  ~SlepcSession();
  SlepcSession(const SlepcSession&) = delete;
  SlepcSession& operator=(const SlepcSession&) = delete;

 private:
  bool begun_ = false;  ///< here
};

}  // namespace voile::solve

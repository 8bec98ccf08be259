// When a step of a motion has converged, whatever the SNES says.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/interrupt.hpp"
#include "step_bound.hpp"
#include "system/sewing_springs.hpp"
#include "time_integration_impl.hpp"

namespace voile::solve {

/// A line search of PETSc: how long the increment is, and how much of it contact allows.
void TimeIntegration::Impl::see_increment(SNESLineSearch search, Vec x, Vec y) {
  Vec f = nullptr;
  VOILE_PETSC(SNESLineSearchGetVecs(search, nullptr, &f, nullptr, nullptr, nullptr));
  VOILE_PETSC(VecDot(f, y, &work));
  VOILE_PETSC(VecNorm(y, NORM_2, &full_increment));
  rms = root_mean_square(y);
  const double allowed = allowed_fraction(model, x, y, trial);
  cut = allowed < 1.0;
  cuts += cut ? 1 : 0;
  shortest = std::min(shortest, allowed);
  if (cut) VOILE_PETSC(VecScale(y, allowed));
}

PetscErrorCode TimeIntegration::Impl::before_line_search(SNESLineSearch ls, Vec x, Vec y, PetscBool* changed,
                                                         void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    n.see_increment(ls, x, y);
    *changed = n.cut ? PETSC_TRUE : PETSC_FALSE;
  });
}

PetscErrorCode TimeIntegration::Impl::after_line_search(SNESLineSearch ls, Vec x, Vec, Vec next, PetscBool* y_changed,
                                                        PetscBool* next_changed, void* self) {
  auto& n = *static_cast<Impl*>(self);
  *y_changed = *next_changed = PETSC_FALSE;
  return petsc::guarded([&] {
    if (n.model.contact()) *next_changed = hold_back(n.model, ls, x, next) ? PETSC_TRUE : PETSC_FALSE;
  });
}

PetscErrorCode TimeIntegration::Impl::after_linear_solve(KSP, Vec rhs, Vec x, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { n.linear.complete_solution(rhs, x); });
}

void TimeIntegration::Impl::confirm(SNES snes, Vec x1) {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  VOILE_PETSC(SNESGetConvergedReason(snes, &reason));
  if (reason <= 0 || (choice.is_newton() && judged_converged)) return;
  double norm = 0.0;
  VOILE_PETSC(SNESComputeFunction(snes, x1, trial));
  VOILE_PETSC(VecNorm(trial, NORM_2, &norm));
  const double force = dynamics.force_scale();
  residual = force > 0.0 ? norm / force : norm;
  if (std::isfinite(norm) && test.is_balanced(norm, force)) return;
  VOILE_PETSC(SNESSetConvergedReason(snes, SNES_DIVERGED_LINE_SEARCH));
}

PetscErrorCode TimeIntegration::Impl::solved(void* self, Vec x1) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    SNES snes = nullptr;
    VOILE_PETSC(TSGetSNES(n.ts, &snes));
    n.confirm(snes, x1);
  });
}

double TimeIntegration::Impl::root_mean_square(Vec y) {
  double square = 0.0, mass = 0.0;
  VOILE_PETSC(VecPointwiseMult(product, model.potential().constant().mass(), y));
  VOILE_PETSC(VecDot(product, y, &square));
  VOILE_PETSC(VecSum(model.potential().constant().mass(), &mass));
  return std::sqrt(3.0 * square / mass);
}

double TimeIntegration::Impl::last_increment(double h) const {
  const system::SewingSprings* sewing = model.potential().sewing();
  return std::min(options.velocity_tolerance * h,
                  sewing ? sewing->resolution() : std::numeric_limits<double>::infinity());
}

SNESConvergedReason TimeIntegration::Impl::judge(SNES snes, PetscInt it, double increment, double norm) {
  const SNESConvergedReason reason = judge_iterate(snes, it, increment, norm);
  judged_converged = reason > 0;
  return reason;
}

SNESConvergedReason TimeIntegration::Impl::judge_iterate(SNES snes, PetscInt it, double increment, double norm) {
  stop_if_asked(model.dofs().comm());
  if (!std::isfinite(norm)) return SNES_DIVERGED_FNORM_NAN;
  const double force = dynamics.force_scale(), before = std::exchange(residual_before, norm);
  residual = force > 0.0 ? norm / force : norm;
  set_tolerance(it, norm, before);
  note_rate(it > 0 && !cut && length == 1.0 && before > 0.0 ? norm / before : 0.0);
  if (it == 0) return test.nothing_to_do(norm, force) ? SNES_CONVERGED_FNORM_ABS : SNES_CONVERGED_ITERATING;
  Vec x = nullptr;
  double step = 0.0, h = 0.0;
  VOILE_PETSC(SNESGetSolution(snes, &x));
  VOILE_PETSC(VecWAXPY(trial, -1.0, start, x));
  VOILE_PETSC(VecNorm(trial, NORM_2, &step));
  VOILE_PETSC(TSGetTimeStep(ts, &h));
  if (test.is_wild(increment)) return SNES_DIVERGED_DTOL;
  // A truncated increment says nothing about how far the solution is.
  if (cut) return it >= test.max_iterations() ? SNES_DIVERGED_MAX_IT : SNES_CONVERGED_ITERATING;
  const bool newton = choice.is_newton() && linear.is_solved();
  if (choice.is_newton() && !own_search) {
    SNESLineSearch search = nullptr;
    VOILE_PETSC(SNESGetLineSearch(snes, &search));
    VOILE_PETSC(SNESLineSearchGetLambda(search, &length));
    increment = std::max(increment, full_increment);
  }
  if (newton && length == 1.0 && rms <= last_increment(h)) return SNES_CONVERGED_SNORM_RELATIVE;
  const SNESConvergedReason reason = test.judge({norm, before, force, increment, step, work, newton});
  if (reason != SNES_CONVERGED_ITERATING) return reason;
  return it >= test.max_iterations() ? SNES_DIVERGED_MAX_IT : SNES_CONVERGED_ITERATING;
}

PetscErrorCode TimeIntegration::Impl::converged(SNES snes, PetscInt it, PetscReal, PetscReal snorm, PetscReal fnorm,
                                                SNESConvergedReason* reason, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { *reason = n.judge(snes, it, it > 0 ? snorm : -1.0, fnorm); });
}

}  // namespace voile::solve

// What PETSc calls back during Newton's method, and when it has converged.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/interrupt.hpp"
#include "newton_impl.hpp"
#include "step_bound.hpp"
#include "system/contact.hpp"

namespace voile::solve {

// ---- callbacks: an exception must not cross PETSc's C frames -------------------------------------------------------

PetscErrorCode Newton::Impl::form_function(SNES, Vec a, Vec r, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { n.model.residual(a, r); });
}

PetscErrorCode Newton::Impl::form_jacobian(SNES, Vec a, Mat, Mat, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    system::TangentRequest request;
    request.kind = energy::Tangent::linearised_stress;
    request.previous = n.has_previous ? static_cast<Vec>(n.previous) : nullptr;
    request.exact_contact = true;
    n.model.assemble_tangent(a, request);
    VOILE_PETSC(VecCopy(a, n.previous));
    n.has_previous = true;
    n.linear.tangent_changed();
  });
}

PetscErrorCode Newton::Impl::converged(SNES, PetscInt it, PetscReal, PetscReal snorm, PetscReal fnorm,
                                       SNESConvergedReason* reason, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { *reason = n.judge(it, it > 0 ? snorm : -1.0, fnorm); });
}

PetscErrorCode Newton::Impl::before_line_search(SNESLineSearch, Vec a, Vec y, PetscBool* changed, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    VOILE_PETSC(VecNorm(y, NORM_2, &n.full_increment));
    n.allowed = allowed_fraction(n.model, a, y, n.trial);
    *changed = n.allowed < 1.0 ? PETSC_TRUE : PETSC_FALSE;
    if (*changed) VOILE_PETSC(VecScale(y, n.allowed));
  });
}

/// Damping options may have made the step longer than what was allowed.
PetscErrorCode Newton::Impl::after_line_search(SNESLineSearch ls, Vec a, Vec, Vec next, PetscBool* y_changed,
                                               PetscBool* next_changed, void* self) {
  auto& n = *static_cast<Impl*>(self);
  *y_changed = *next_changed = PETSC_FALSE;
  return petsc::guarded([&] { *next_changed = hold_back(n.model, ls, a, next) ? PETSC_TRUE : PETSC_FALSE; });
}

PetscErrorCode Newton::Impl::before_linear_solve(KSP, Vec rhs, Vec, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    if (n.model.tangent().fixed_coupling()) VOILE_PETSC(VecAXPY(rhs, -1.0, n.model.tangent().fixed_coupling()));
  });
}

PetscErrorCode Newton::Impl::after_linear_solve(KSP, Vec rhs, Vec x, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    n.linear.check_solution(rhs, x);
    if (n.model.tangent().fixed_coupling()) VOILE_PETSC(VecAXPY(rhs, 1.0, n.model.tangent().fixed_coupling()));
    VOILE_PETSC(VecDot(rhs, x, &n.last_work));
  });
}

// ---- convergence ---------------------------------------------------------------------------------------------------

SNESConvergedReason Newton::Impl::judge(PetscInt iteration, double increment_norm, double residual_norm) {
  const SNESConvergedReason reason = judge_iterate(iteration, increment_norm, residual_norm);
  judged_converged = reason > 0;
  return reason;
}

SNESConvergedReason Newton::Impl::judge_iterate(PetscInt iteration, double increment_norm, double residual_norm) {
  stop_if_asked(model.dofs().comm());
  if (!std::isfinite(residual_norm)) return SNES_DIVERGED_FNORM_NAN;
  const double force = model.force_scale(), before = std::exchange(last_residual, residual_norm);
  if (increment_norm < 0.0) {
    if (test.nothing_to_do(residual_norm, force)) return SNES_CONVERGED_FNORM_ABS;
  } else {
    Vec a = nullptr;
    VOILE_PETSC(SNESGetSolution(snes, &a));
    VOILE_PETSC(VecWAXPY(trial, -1.0, start, a));
    VOILE_PETSC(VecNorm(trial, NORM_2, &step_norm));
    if (test.is_wild(increment_norm)) return SNES_DIVERGED_DTOL;
    if (allowed < 1.0) return iteration >= test.max_iterations() ? SNES_DIVERGED_MAX_IT : SNES_CONVERGED_ITERATING;
    const double increment = choice.is_newton() ? std::max(increment_norm, full_increment) : increment_norm;
    const SNESConvergedReason reason = test.judge(
        {residual_norm, before, force, increment, step_norm, last_work, choice.is_newton() && linear.is_solved()});
    if (reason != SNES_CONVERGED_ITERATING) return reason;
  }
  return iteration >= test.max_iterations() ? SNES_DIVERGED_MAX_IT : SNES_CONVERGED_ITERATING;
}

void Newton::Impl::confirm(Vec a, NewtonResult& result) {
  if (!result.converged || (choice.is_newton() && judged_converged)) return;
  double norm = 0.0;
  model.residual(a, residual);
  VOILE_PETSC(VecNorm(residual, NORM_2, &norm));
  result.residual = model.force_scale() > 0.0 ? norm / model.force_scale() : norm;
  if (std::isfinite(norm) && test.is_balanced(norm, model.force_scale())) return;
  result.converged = false;
  result.reason += fmt::format(", but the residual is {:.2e} of the forces", result.residual);
}

}  // namespace voile::solve

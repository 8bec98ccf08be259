#include "newton.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/interrupt.hpp"
#include "base/mpi.hpp"
#include "newton_impl.hpp"
#include "step_bound.hpp"
#include "system/contact.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

namespace {

/// Relative residual below which continuation uses the exact tangent, and below which it hands over to Newton.
constexpr double exact_tangent_below = 1e-2, handover_below = 1e-4;
/// Slip below which friction is smoothed in a load step.
constexpr double slip_in_cells = 1e-3;
/// Rounds in which friction follows the normal forces, and the residual (of the forces) at which it does.
constexpr int friction_lags = 30;
constexpr double friction_settled = 1e-6;
/// What a linear solution may leave of its forces: factors of large thin shells leave up to 1e-3 by their round-off.
constexpr double unsolved_linear = 1e-2;
/// Iterations of continuation between two words on its progress.
constexpr int progress_every = 100;

}  // namespace

// ---- set-up --------------------------------------------------------------------------------------------------------

void Newton::Impl::create() {
  VOILE_PETSC(SNESCreate(model.dofs().comm(), snes.out()));
  VOILE_PETSC(SNESSetType(snes, SNESNEWTONLS));
  VOILE_PETSC(SNESSetFunction(snes, residual, form_function, this));
  VOILE_PETSC(SNESSetJacobian(snes, model.tangent().matrix(), model.tangent().matrix(), form_jacobian, this));
  VOILE_PETSC(SNESSetConvergenceTest(snes, converged, this, nullptr));
  VOILE_PETSC(SNESSetTolerances(snes, PETSC_DEFAULT, 1e-8, 1e-6, 20, PETSC_MAX_INT));
  SNESLineSearch line_search = nullptr;
  VOILE_PETSC(SNESGetLineSearch(snes, &line_search));
  VOILE_PETSC(SNESLineSearchSetType(line_search, SNESLINESEARCHBASIC));
  VOILE_PETSC(SNESLineSearchSetPreCheck(line_search, before_line_search, this));
  if (model.contact()) VOILE_PETSC(SNESLineSearchSetPostCheck(line_search, after_line_search, this));
  KSP ksp = nullptr;
  VOILE_PETSC(SNESGetKSP(snes, &ksp));
  linear.set_defaults(ksp);
  VOILE_PETSC(KSPSetPreSolve(ksp, before_linear_solve, this));
  VOILE_PETSC(KSPSetPostSolve(ksp, after_linear_solve, this));
  refuse_snes_options();
  VOILE_PETSC(SNESSetFromOptions(snes));
  VOILE_PETSC(SNESSetConvergenceTest(snes, converged, this, nullptr));  // an option may have put another in its place
  linear.prepare();
  test.read(snes);
  choice.read(snes, model.contact() != nullptr);
  if (!choice.is_current()) linear.expect_stale_factor();
}

// ---- Newton --------------------------------------------------------------------------------------------------------

NewtonResult Newton::Impl::solve_once(Vec a) {
  has_previous = judged_converged = false;
  full_increment = 0.0;
  allowed = 1.0;
  const int before = linear.factorisations();
  VOILE_PETSC(VecCopy(a, start));
  test.see(a);
  const PetscErrorCode code = SNESSolve(snes, nullptr, a);
  petsc::check(code, "SNESSolve");
  NewtonResult result;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  PetscReal norm = 0.0;
  const char* text = nullptr;
  VOILE_PETSC(SNESGetConvergedReason(snes, &reason));
  VOILE_PETSC(SNESGetIterationNumber(snes, &iterations));
  VOILE_PETSC(SNESGetFunctionNorm(snes, &norm));
  VOILE_PETSC(SNESGetConvergedReasonString(snes, &text));
  result.converged = reason > 0;
  result.iterations = iterations;
  result.factorisations = linear.factorisations() - before;
  result.residual = model.force_scale() > 0.0 ? norm / model.force_scale() : norm;
  result.negative_pivots = linear.negative_pivots();
  result.reason = text;
  confirm(a, result);
  return result;
}

NewtonResult Newton::step(Vec a) {
  petsc::VecHandle origin = impl_->model.dofs().create_vector();
  VOILE_PETSC(VecCopy(a, origin));
  int spent = 0;
  for (int attempt = 0;; ++attempt) {
    NewtonResult result = impl_->solve_once(a);
    result.factorisations += spent;
    if (result.converged) return result;
    const bool again = impl_->linear.repair(attempt);
    if (const std::string failure = impl_->linear.take_failure(); !failure.empty())
      result.reason += " (" + failure + ")";
    if (!again) return result;
    spent = result.factorisations;
    VOILE_PETSC(VecCopy(origin, a));
  }
}

// ---- pseudo-transient continuation ---------------------------------------------------------------------------------

double Newton::Impl::backtrack(Vec a, double longest, double energy, double slope) {
  for (double length = longest; length > 1e-4 * longest; length *= 0.5) {
    VOILE_PETSC(VecWAXPY(trial, -length, increment, a));
    const double new_energy = model.energy(trial);
    const double round_off = 1e-13 * std::abs(energy);
    if (std::isfinite(new_energy) && new_energy <= energy - 1e-4 * length * slope + round_off) return length;
  }
  return 0.0;
}

std::pair<double, double> Newton::Impl::advance(Vec a, double energy) {
  double slope = 0.0;
  VOILE_PETSC(VecDot(residual, increment, &slope));
  // Prescribed motion does work that the energy balance does not see: the first step then moves the supports in full.
  const bool balanced = model.conditions().symmetric() && model.tangent().fixed_coupling() == nullptr;
  const double most = allowed_fraction(model, a, increment, trial);
  const double length = balanced ? backtrack(a, most, energy, slope) : most;
  VOILE_PETSC(VecAXPY(a, -length, increment));
  return {length, most};
}

double Newton::Impl::first_shift() {
  const double cell = std::sqrt(model.discretisation().mean_area());
  double acceleration = 0.0;
  VOILE_PETSC(VecPointwiseDivide(trial, residual, model.potential().constant().mass()));
  VOILE_PETSC(VecNorm(trial, NORM_INFINITY, &acceleration));
  return std::max(acceleration / cell, 1e-30);
}

void Newton::Impl::assemble_shifted(Vec a, bool exact, double shift) {
  system::TangentRequest request;
  request.kind = exact ? energy::Tangent::exact : energy::Tangent::positive;
  request.mass = shift;
  request.exact_contact = exact;
  model.assemble_tangent(a, request);
  linear.tangent_changed();
}

NewtonResult Newton::polish(Vec a) {
  Impl& n = *impl_;
  petsc::VecHandle kept = n.model.dofs().create_vector();
  VOILE_PETSC(VecCopy(a, kept));
  NewtonResult result = step(a);
  if (result.converged) return result;
  VOILE_PETSC(VecCopy(kept, a));
  n.model.residual(a, n.residual);
  return result;
}

NewtonResult Newton::continuation(Vec a, int max_iterations) {
  Impl& n = *impl_;
  system::Model& model = n.model;
  NewtonResult result;
  const int before = n.linear.factorisations();
  double shift = -1.0, energy = 0.0, handover = handover_below;
  int linear_failures = 0;
  n.largest_force = 0.0;
  n.test.see(a);
  // mesh.start may have what is held a little off: tangents couple to that only where supports are prescribed to move.
  if (!model.contact() && !model.conditions().has_prescribed()) model.conditions().enforce(a);
  for (result.iterations = 0; result.iterations < max_iterations; ++result.iterations) {
    stop_if_asked(model.dofs().comm());
    double norm = 0.0;
    model.residual(a, n.residual);
    VOILE_PETSC(VecNorm(n.residual, NORM_2, &norm));
    VOILE_PETSC(SNESMonitor(n.snes, result.iterations, norm));
    if (!std::isfinite(norm)) break;
    result.residual = n.relative(norm);
    if (n.progress && result.iterations > 0 && result.iterations % progress_every == 0)
      n.progress(result.iterations, result.residual);
    if (shift < 0.0) {
      shift = n.first_shift();
      energy = n.energy_at(a);
    }
    if (result.residual < handover) {
      NewtonResult polished = polish(a);
      polished.iterations += result.iterations;
      polished.factorisations = n.linear.factorisations() - before;
      if (polished.converged) return polished;
      handover = 0.1 * result.residual;
    }
    const bool exact = result.residual < exact_tangent_below;
    n.assemble_shifted(a, exact, shift);
    if (!n.linear.solve(n.residual, n.increment)) {
      shift *= 8.0;
      if (++linear_failures < 10) continue;
      result.reason = "the linear solver failed: " + n.linear.take_failure();
      break;
    }
    if (exact && n.linear.negative_pivots() > 0) {  // on a ridge of the energy: more shift makes the step a descent
      shift *= 4.0;
      continue;
    }
    const auto [length, allowed] = n.advance(a, energy);
    if (length == 0.0) {
      shift *= 8.0;
      continue;
    }
    energy = n.energy_at(a);
    // A step that contact cut short says nothing against the shift.
    shift *= length == 1.0 ? 0.5 : length == allowed ? 1.0 : 2.0;
  }
  result.factorisations = n.linear.factorisations() - before;
  result.negative_pivots = n.linear.negative_pivots();
  if (result.reason.empty()) result.reason = "continuation did not settle";
  return result;
}

Newton::Newton(system::Model& model) : impl_(std::make_unique<Impl>(model)) {
  impl_->create();
}
Newton::~Newton() = default;
SNES Newton::snes() const {
  return impl_->snes;
}
linear::LinearSolver& Newton::linear_solver() {
  return impl_->linear;
}
const ConvergenceTest& Newton::convergence() const {
  return impl_->test;
}

void Newton::on_progress(std::function<void(int, double)> progress) {
  impl_->progress = std::move(progress);
}

void Newton::start_friction(Vec a) {
  system::Contact* contact = impl_->model.contact();
  if (!contact || !contact->scene().set().has_friction()) return;
  const double given = contact->scene().input().options.slip_distance;
  const double cell = std::sqrt(impl_->model.discretisation().mean_area());
  contact->start_step(a, given > 0.0 ? given : slip_in_cells * cell);
}

NewtonResult Newton::settle_friction(Vec a, NewtonResult first, const std::function<NewtonResult()>& solve) {
  Impl& n = *impl_;
  system::Contact* contact = n.model.contact();
  NewtonResult result = std::move(first);
  if (!contact || !contact->scene().set().has_friction()) return result;
  for (int k = 0; k < friction_lags && result.converged; ++k) {
    double norm = 0.0;
    contact->lag_friction(a);
    n.model.residual(a, n.residual);
    VOILE_PETSC(VecNorm(n.residual, NORM_2, &norm));
    if (norm <= friction_settled * n.model.force_scale()) return result;
    NewtonResult next = solve();
    next.iterations += result.iterations;
    next.factorisations += result.factorisations;
    result = std::move(next);
  }
  if (result.converged) {
    result.converged = false;
    result.reason = fmt::format("friction did not settle in {} rounds", friction_lags);
  }
  return result;
}

long Newton::negative_eigenvalues(Vec a) {
  Impl& n = *impl_;
  system::TangentRequest request;
  request.exact_contact = true;
  n.model.assemble_tangent(a, request);
  n.linear.tangent_changed();
  return n.linear.factorise() ? n.linear.certain_negative_eigenvalues() : -1;
}

NewtonResult Newton::linear_step(Vec a) {
  Impl& n = *impl_;
  NewtonResult result;
  const int before = n.linear.factorisations();
  n.model.residual(a, n.residual);
  n.model.potential().hold_natural_states(true);  // stresses of the load do not stiffen
  n.model.assemble_tangent(a, {.kind = energy::Tangent::exact, .loads = false});
  n.model.potential().hold_natural_states(false);
  n.linear.tangent_changed();
  result.converged = n.linear.solve(n.residual, n.increment);
  result.iterations = 1;
  result.factorisations = n.linear.factorisations() - before;
  result.negative_pivots = n.linear.negative_pivots();
  result.reason = result.converged ? "linear" : "the linear solver failed: " + n.linear.take_failure();
  if (!result.converged) return result;
  VOILE_PETSC(VecAXPY(a, -1.0, n.increment));
  // What is left of the linear equations K dx = r.
  n.model.tangent().multiply(n.increment, n.trial);
  if (n.model.tangent().fixed_coupling()) VOILE_PETSC(VecAXPY(n.trial, 1.0, n.model.tangent().fixed_coupling()));
  VOILE_PETSC(VecAXPY(n.trial, -1.0, n.residual));
  VOILE_PETSC(VecNorm(n.trial, NORM_2, &result.residual));
  double force = 0.0;
  VOILE_PETSC(VecNorm(n.residual, NORM_2, &force));
  if (force > 0.0) result.residual /= force;
  if (result.residual <= unsolved_linear) return result;
  result.converged = false;
  result.reason = fmt::format(
      "the linear solver left {:.2g} of the forces unbalanced; give it a lower -ksp_rtol, or use "
      "the direct solver (the default)",
      result.residual);
  return result;
}

}  // namespace voile::solve

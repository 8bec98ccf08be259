// Path following: tangent, predictor and Newton's method on the residual and the constraint.
#include "base/interrupt.hpp"
#include "path_following_impl.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

namespace {

constexpr int iterations_per_step = 3;  ///< per step; the mode of the step before is a good start

}  // namespace

PathFollower::Impl::Tangent PathFollower::Impl::tangent_at(Vec a) {
  Tangent t;
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  linear.tangent_changed();
  model.load_direction(a, load);
  t.good = linear.solve_to(linear::well_solved, load, load_solution);
  if (!t.good) return t;
  t.speed = std::sqrt(dot(load_solution, load_solution));
  t.good = std::isfinite(t.speed) && t.speed > 0.0;
  const linear::NegativeEigenvalues negative = linear.count_negative();
  t.negative_pivots = negative.likely;
  t.certain = negative.certain;
  if (!t.good) return t;
  VOILE_PETSC(VecCopy(mode, last_mode));
  t.eigenvalue = linear::inverse_iteration(model, linear, mode, iterations_per_step);
  t.kept = std::abs(dot(mode, last_mode));
  double work = 0.0, size = 0.0, force = 0.0;
  VOILE_PETSC(VecDot(mode, load, &work));
  VOILE_PETSC(VecNorm(mode, NORM_2, &size));
  VOILE_PETSC(VecNorm(load, NORM_2, &force));
  if (size * force > 0.0) t.pushed = std::abs(work) / (size * force);
  // At a bifurcation K^-1 f is whatever round-off makes of the mode that f does not push: a path that did not come along it goes on
  // without it.
  const double along = dot(mode, load_solution);
  Vec way = dot(increment, increment) > 0.0 ? static_cast<Vec>(increment) : static_cast<Vec>(previous);
  const double come = std::sqrt(dot(way, way));
  if (t.pushed >= not_pushed || std::abs(along) <= 0.5 * t.speed || std::abs(dot(mode, way)) >= 0.5 * come) return t;
  VOILE_PETSC(VecAXPY(load_solution, -along, mode));
  t.speed = std::sqrt(dot(load_solution, load_solution));
  t.good = t.speed > 0.0;
  return t;
}

double PathFollower::Impl::load_correction(const Constraint& constraint) const {
  if (constraint.nearest) return dot(load_solution, residual_solution) / dot(load_solution, load_solution);
  switch (constraint.kind) {
    case Control::load:
      return 0.0;
    case Control::displacement:
      return (constraint.value - probed(accepted) - probed(increment) + probed(residual_solution)) /
             probed(load_solution);
    case Control::arc_length:
      break;
  }
  return (0.5 * (constraint.value * constraint.value - dot(increment, increment)) + dot(increment, residual_solution)) /
         dot(increment, load_solution);
}

/// Newton's method on (r, constraint), from accepted + increment at `lambda`.
NewtonResult PathFollower::Impl::correct(Vec a, double& lambda, const Constraint& constraint) {
  NewtonResult n;
  const int before = linear.factorisations();
  Progress p;
  const ConvergenceTest& test = newton.convergence();
  for (n.iterations = 0;; ++n.iterations) {
    stop_if_asked(model.dofs().comm());
    VOILE_PETSC(VecWAXPY(a, 1.0, increment, accepted));
    model.conditions().set_load_factor(lambda);
    model.residual(a, residual);
    p.residual_before = p.residual;
    VOILE_PETSC(VecNorm(residual, NORM_2, &p.residual));
    VOILE_PETSC(SNESMonitor(newton.snes(), n.iterations, p.residual));
    p.force = std::max(force, model.force_scale());
    n.residual = p.force > 0.0 ? p.residual / p.force : p.residual;
    n.factorisations = linear.factorisations() - before;
    if (!std::isfinite(p.residual) || test.is_wild(p.increment)) {
      n.reason = "the iteration ran away";
      return n;
    }
    if (n.iterations > 0) {
      const SNESConvergedReason reason = test.judge(p);
      n.converged = reason > 0;
      n.reason = SNESConvergedReasons[reason];
      if (n.converged) return n;
    }
    if (n.iterations >= test.max_iterations()) {
      n.reason = "too many iterations";
      return n;
    }
    model.assemble_tangent(a, {.kind = energy::Tangent::exact});
    linear.tangent_changed();
    model.load_direction(a, load);
    if (!linear.solve(residual, residual_solution) || !linear.solve(load, load_solution)) {
      n.reason = "the linear solver failed: " + linear.take_failure();
      return n;
    }
    const double change = load_correction(constraint);
    if (!std::isfinite(change)) {
      n.reason = "the constraint became singular";
      return n;
    }
    VOILE_PETSC(VecAXPBY(residual_solution, change, -1.0, load_solution));  // da
    VOILE_PETSC(VecAXPY(increment, 1.0, residual_solution));
    lambda += change;
    VOILE_PETSC(VecNorm(residual_solution, NORM_2, &p.increment));
    VOILE_PETSC(VecNorm(increment, NORM_2, &p.step));
    VOILE_PETSC(VecDot(residual, residual_solution, &p.work));
    p.is_newton = linear.is_solved();
  }
}

/// What keeps the place of a state along the path on another mesh, whose limit loads may be lower than the load in force.
PathFollower::Impl::Constraint PathFollower::Impl::constraint_of_place(double probed_before) const {
  const bool by_probe = options.final_displacement != 0.0;
  if (is_end(probed_before, factor))
    return {by_probe ? Control::displacement : Control::load, options.final_displacement};
  if (options.control == Control::displacement) return {Control::displacement, probed_before};
  return {Control::arc_length, 0.0, true};
}

NewtonResult PathFollower::Impl::regain(system::State& state, double probed_before) {
  start_from(state);
  VOILE_PETSC(VecZeroEntries(increment));
  const bool by_probe = options.final_displacement != 0.0;
  const double before = by_probe ? probed_before : factor,
               end = by_probe ? options.final_displacement : options.final_load_factor;
  const Constraint place = constraint_of_place(probed_before);
  double lambda = factor;
  NewtonResult n = correct(state.u, lambda, place);
  const double now = by_probe ? probed(state.u) : lambda;
  if (n.converged && place.nearest && (now - end) * (before - end) <= 0.0) {  // the end must not be left behind
    if (!by_probe) lambda = end;
    n = correct(state.u, lambda, {by_probe ? Control::displacement : Control::load, end});
  }
  state.in_equilibrium = n.converged;
  if (n.converged) {
    state.load_factor = lambda;
    n.negative_pivots = tangent_at(state.u).negative_pivots;
  }
  return n;
}

/// Sets the increment, lambda and the rate from the tangent at the accepted state.
void PathFollower::Impl::predict(const Constraint& constraint, double& lambda) {
  double change = lambda - factor;
  if (constraint.kind == Control::displacement)
    change = (constraint.value - probed(accepted)) / probed(tangent_solution);
  if (constraint.kind == Control::arc_length) {
    double sign = dot(previous, tangent_solution);
    if (sign == 0.0) sign = 1.0;  // loads act as they are given, wherever the probe goes at first
    change = std::copysign(constraint.value / tangent.speed, sign);
  }
  rate = std::copysign(1.0 / tangent.speed, change);
  lambda = factor + change;
  VOILE_PETSC(VecCopy(tangent_solution, increment));
  VOILE_PETSC(VecScale(increment, change));
}

}  // namespace voile::solve

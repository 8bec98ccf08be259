#include "load_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "base/interrupt.hpp"
#include "stall.hpp"
#include "step_bound.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

namespace {

/// Halvings in a row before continuation is tried.
constexpr int halvings_before_continuation = 1;
/// Iterations of a step in which barriers change places; target_iterations is for steps without.
constexpr int usual_in_contact = 10;

}  // namespace

namespace {

/// The options as PETSc types.
struct PathOptions {
  PetscInt control, critical;
  PetscReal initial, least, most;
  PetscInt steps, target;
};

/// PETSc's macros return an error code from the function they stand in.
PetscErrorCode ask(MPI_Comm comm, PathOptions& o) {
  static constexpr const char* controls[] = {"load", "displacement", "arc_length"};
  static constexpr const char* answers[] = {"pass", "stop", "switch_branch"};
  PetscOptionsBegin(comm, "path_", "Load path", nullptr);
  // Lists, not enumerations: PetscEnum has no values of its own, and loading another one is undefined.
  PetscCall(PetscOptionsEList("-control", "What a step prescribes", nullptr, controls, 3, controls[o.control],
                              &o.control, nullptr));
  PetscCall(PetscOptionsReal("-initial_step", "First step", nullptr, o.initial, &o.initial, nullptr));
  PetscCall(PetscOptionsReal("-min_step", "Smallest step", nullptr, o.least, &o.least, nullptr));
  PetscCall(PetscOptionsReal("-max_step", "Largest step", nullptr, o.most, &o.most, nullptr));
  PetscCall(PetscOptionsInt("-max_steps", "Largest number of steps", nullptr, o.steps, &o.steps, nullptr));
  PetscCall(PetscOptionsInt("-target_iterations", "Iterations at which a step keeps its size", nullptr, o.target,
                            &o.target, nullptr));
  PetscCall(PetscOptionsEList("-at_critical_point", "At a limit or bifurcation point", nullptr, answers, 3,
                              answers[o.critical], &o.critical, nullptr));
  PetscOptionsEnd();
  return 0;
}

}  // namespace

void read_path_options(MPI_Comm comm, StaticOptions& options) {
  PathOptions o{static_cast<PetscInt>(options.control),
                static_cast<PetscInt>(options.at_critical_point),
                options.initial_step,
                options.min_step,
                options.max_step,
                options.max_steps,
                options.target_iterations};
  VOILE_PETSC(ask(comm, o));
  if (!(o.least > 0.0 && o.initial >= o.least && o.most >= o.initial && o.steps > 0 && o.target > 0))
    throw UserError(
        "options -path_...: 0 < -path_min_step <= -path_initial_step <= -path_max_step, and positive -path_max_steps "
        "and -path_target_iterations are needed");
  options.control = static_cast<StaticOptions::Control>(o.control);
  options.at_critical_point = static_cast<StaticOptions::AtCriticalPoint>(o.critical);
  options.initial_step = o.initial;
  options.min_step = o.least;
  options.max_step = o.most;
  options.max_steps = static_cast<int>(o.steps);
  options.target_iterations = static_cast<int>(o.target);
  if (options.control == StaticOptions::Control::displacement &&
      (options.control_probe.empty() || options.final_displacement == 0.0))
    throw UserError("-path_control displacement: the case must give [steps] control_probe and final_displacement");
}

namespace {

/// Folds that are constant grow from the flat shape to their whole in so many parts, less where that fails. Newton's method does not
/// find a sheet that is folded by 45 degrees from one that is flat.
constexpr double first_part = 0.25, least_part = 1e-3;

/// From the state u to that at fraction 1 of what `set` changes, in steps of Newton's method; where it ends before, by continuation.
NewtonResult in_parts(Newton& newton, system::Model& model, Vec u, const std::function<void(double)>& set) {
  const petsc::VecHandle accepted = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(u, accepted));
  NewtonResult all;
  const auto tally = [&](NewtonResult n) {
    n.iterations += all.iterations;
    n.factorisations += all.factorisations;
    all = std::move(n);
  };
  double at = 0.0;
  for (double part = first_part; at < 1.0 && part >= least_part;) {
    const double next = std::min(1.0, at + part);
    set(next);
    tally(newton.step(u));
    VOILE_PETSC(
        VecCopy(all.converged ? u : static_cast<Vec>(accepted), all.converged ? static_cast<Vec>(accepted) : u));
    if (all.converged) at = next;
    part = all.converged ? std::min(first_part, 2.0 * part) : 0.5 * part;
  }
  set(1.0);
  if (at < 1.0) tally(newton.continuation(u));
  return all;
}

NewtonResult grow_folds(Newton& newton, system::Model& model, Vec u) {
  return in_parts(newton, model, u, [&](double fraction) { model.potential().ease_folds(fraction); });
}

/// What has been taken away since the state `start` goes bit by bit: its residual is held by forces that go.
NewtonResult let_go(Newton& newton, system::Model& model, Vec start, Vec u) {
  const petsc::VecHandle held = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(start, u));
  model.residual(u, held);
  model.dofs().clear_fixed(held);
  system::BoundaryConditions& conditions = model.conditions();
  petsc::VecHandle own = conditions.take_external();
  const auto hold = [&](double fraction) {
    petsc::VecHandle force = model.dofs().create_vector();
    if (own) VOILE_PETSC(VecCopy(own, force));
    VOILE_PETSC(VecAXPY(force, 1.0 - fraction, held));
    conditions.set_external(std::move(force));
  };
  NewtonResult n;
  try {
    n = in_parts(newton, model, u, hold);
  } catch (...) {  // a signal
    conditions.set_external(std::move(own));
    throw;
  }
  conditions.set_external(std::move(own));
  return n;
}

}  // namespace

StepResult find_equilibrium(system::Model& model, system::State& state) {
  StepResult r;
  model.conditions().set_load_factor(state.load_factor);
  if (state.in_equilibrium) return r;
  Newton newton(model);
  double moved = 0.0;
  VOILE_PETSC(VecNorm(state.u, NORM_INFINITY, &moved));
  const bool folds = moved == 0.0 && model.potential().has_constant_folds();
  // From here on friction resists: without it a sheet that rests on a slope would slide off.
  newton.start_friction(state.u);
  const auto search = [&] { return newton.continuation(state.u); };
  const petsc::VecHandle start = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(state.u, start));
  NewtonResult n = folds ? grow_folds(newton, model, state.u) : newton.settle_friction(state.u, search(), search);
  if (!n.converged && !folds && moved > 0.0 && !model.contact() && !model.dofs().has_bodies())
    n = let_go(newton, model, start, state.u);
  r.newton_iterations = n.iterations;
  r.factorisations = n.factorisations;
  state.in_equilibrium = n.converged;
  if (n.converged) model.potential().end_step(state.u);
  if (n.converged) return r;
  r.outcome = Outcome::failed;
  r.reason = "no equilibrium found near the start: " + n.reason +
             "; where loads or supports have gone, let a stage of \"drape\" find it, or take them away in steps";
  return r;
}

bool is_balanced(system::Model& model, Vec u) {
  constexpr double unbalanced = 1e-6;  // of the forces: runs end well below, cases that differ are beyond
  const petsc::VecHandle a = model.dofs().create_vector(), residual = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(u, a));
  model.conditions().enforce(a);
  double size = 0.0;
  model.residual(a, residual);
  model.dofs().clear_fixed(residual);
  VOILE_PETSC(VecNorm(residual, NORM_2, &size));
  return size <= unbalanced * model.force_scale();
}

StepResult regain_equilibrium(system::Model& model, system::State& state) {
  model.conditions().set_load_factor(state.load_factor);
  const petsc::VecHandle start = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(state.u, start));
  StepResult r;
  Newton newton(model);
  r.newton = newton.step(state.u);
  r.newton_iterations = r.newton.iterations;
  r.factorisations = r.newton.factorisations;
  state.in_equilibrium = r.newton.converged && r.newton.negative_pivots <= 0;
  if (state.in_equilibrium) return r;
  VOILE_PETSC(VecCopy(start, state.u));
  r.outcome = Outcome::failed;
  r.reason = r.newton.converged ? "an unstable state was found" : r.newton.reason;
  return r;
}

double LoadPath::next_target(double from, double step) const {
  const double direction = options_.final_load_factor >= from ? 1.0 : -1.0;
  const double slack = 1e-9 * std::max(1.0, std::abs(options_.final_load_factor));
  // A remainder of less than a tenth of a step is taken along; the nearest stop within reach wins.
  double nearest = 1.1 * step, target = from + direction * step;
  const auto limit = [&](double stop, double least) {
    const double distance = direction * (stop - from);
    if (distance <= least || distance >= nearest) return;
    nearest = distance;
    target = stop;
  };
  limit(options_.final_load_factor, 0.0);
  for (const double stop : options_.stops) limit(stop, slack);
  double fraction = fraction_by_turn(model_, from, target, true);
  if (obstacles_move_) fraction = std::min(fraction, fraction_by_obstacles(model_, from, target));
  if (fraction == 1.0) return target;
  // What jumps is tried as a jump: no smaller step would see less of it.
  const double whole = std::abs(target - from);
  return from + direction * std::max(fraction * whole, std::min(whole, options_.min_step));
}

bool at_load_factor(double wanted, double factor) {
  return std::abs(wanted - factor) <= 1e-12 * std::max(1.0, std::abs(wanted));
}

bool LoadPath::finished(const system::State& state) const {
  return at_load_factor(options_.final_load_factor, state.load_factor);
}

StepResult LoadPath::begin(system::State& state) {
  newton_.emplace(model_);
  if (state.in_equilibrium && model_.contact()) {
    recall_friction(state);
    if (restarted_ && finished(state))
      state.in_equilibrium = is_balanced(model_, state.u);  // no step will come to show it
  }
  StepResult r = find_equilibrium(model_, state);
  accepted_ = model_.dofs().create_vector();
  VOILE_PETSC(VecCopy(state.u, accepted_));
  step_ = state.next_step > 0.0 ? std::min(state.next_step, options_.max_step) : options_.initial_step;
  halvings_ = 0;
  if (finished(state) && r.outcome != Outcome::failed)
    r.newton.negative_pivots = newton_->negative_eigenvalues(state.u);
  return r;
}

void LoadPath::recall_friction(const system::State& state) {
  if (!state.previous || !(state.path.unit < 0.0)) return;
  set_load_factor(state.load_factor + state.path.rate * state.path.unit);
  newton_->start_friction(state.previous);
  set_load_factor(state.load_factor);
  if (model_.contact()->scene().set().has_friction()) model_.contact()->lag_friction(state.u);
}

void LoadPath::predict(system::State& state, double to) const {
  if (!state.previous || !(state.path.unit < 0.0)) return;
  const double ratio = (state.load_factor - to) / (state.path.rate * state.path.unit);
  VOILE_PETSC(VecAXPBY(state.u, -ratio, 1.0 + ratio, state.previous));
}

void LoadPath::set_load_factor(double factor) {
  model_.conditions().set_load_factor(factor);
  if (obstacles_move_) model_.contact()->set_time(factor);
}

NewtonResult LoadPath::settle(system::State& state, double to, bool by_continuation) {
  const Vec a = state.u;
  const auto solve = [&] { return by_continuation ? newton_->continuation(a) : newton_->step(a); };
  set_load_factor(state.load_factor);
  VOILE_PETSC(VecCopy(accepted_, a));
  newton_->start_friction(accepted_);
  model_.conditions().set_load_factor(to);
  if (obstacles_move_) {
    if (!by_continuation) predict(state, to);
    const system::Contact::Clearance way = model_.contact()->clear_predictor(accepted_, state.load_factor, a, to);
    if (!way.clear) {
      NewtonResult none;
      none.reason = "an obstacle leaves no room: " + way.obstruction;
      return none;
    }
  }
  return newton_->settle_friction(a, solve(), solve);
}

StepResult LoadPath::advance(system::State& state) {
  StepResult r;
  r.outcome = Outcome::failed;
  if (state.path.steps >= options_.max_steps) {
    r.reason = fmt::format("max_steps = {} steps did not reach the end of the path", options_.max_steps);
    return r;
  }
  try {
    return attempt(state);
  } catch (const Interrupted& e) {
    VOILE_PETSC(VecCopy(accepted_, state.u));
    set_load_factor(state.load_factor);
    r.interrupted = true;
    r.reason = e.what();
    return r;
  }
}

/// One step, tried as Newton's method and, after a halving, by continuation.
StepResult LoadPath::attempt(system::State& state) {
  StepResult r;
  const double target = next_target(state.load_factor, step_), taken = std::abs(target - state.load_factor);
  const auto tally = [&] {
    r.newton_iterations += r.newton.iterations;
    r.factorisations += r.newton.factorisations;
  };
  r.newton = settle(state, target, false);
  tally();
  if (!r.newton.converged && options_.fallback && halvings_ == halvings_before_continuation) {
    remark(fmt::format("load factor {:.6g}: {} after {} iterations; trying pseudo-transient continuation", target,
                       r.newton.reason, r.newton.iterations));
    r.newton = settle(state, target, true);
    tally();
    r.by_continuation = true;
  }
  if (!r.newton.converged) {
    halve(state, r, target, taken);
    return r;
  }
  // Newton's last tangent is that of the iterate before, with other stresses: what it says is looked at again.
  const bool last = at_load_factor(options_.final_load_factor, target);
  if (last || r.newton.negative_pivots > 0 || !model_.conditions().symmetric())
    r.newton.negative_pivots = newton_->negative_eigenvalues(state.u);
  model_.potential().end_step(state.u);
  if (model_.contact()) {
    if (!state.previous) state.previous = model_.dofs().create_vector();
    VOILE_PETSC(VecCopy(accepted_, state.previous));
    state.path.unit = -taken;
    state.path.rate = target > state.load_factor ? 1.0 : -1.0;
  }
  VOILE_PETSC(VecCopy(state.u, accepted_));
  state.load_factor = target;
  state.v.reset();
  state.a.reset();
  ++state.step;
  ++state.path.steps;
  r.taken = taken;
  // A step cut short by a stop says nothing against the step size in force; one after a failure does not grow,
  // unless continuation took it, which does not mind long steps.
  const int usual =
      model_.contact() ? std::max(options_.target_iterations, usual_in_contact) : options_.target_iterations;
  const bool easy = r.by_continuation || (r.newton.iterations <= usual && halvings_ == 0);
  if (easy && taken > 0.9 * step_) step_ = std::min(options_.max_step, 2.0 * step_);
  halvings_ = 0;
  state.next_step = step_;
  return r;
}

/// After a step that failed.
void LoadPath::halve(system::State& state, StepResult& r, double target, double taken) {
  const std::string place = 0.5 * taken < options_.min_step ? "; " + largest_residuals_at(model_, state.u) : "";
  VOILE_PETSC(VecCopy(accepted_, state.u));
  set_load_factor(state.load_factor);
  ++halvings_;
  step_ = 0.5 * taken;
  remark(fmt::format("load factor {:.6g}: {} after {} iterations; step halved to {:.3g}", target, r.newton.reason,
                     r.newton.iterations, step_));
  r.outcome = step_ >= options_.min_step ? Outcome::not_yet : Outcome::failed;
  if (r.outcome == Outcome::failed)
    r.reason = fmt::format(
        "no equilibrium found beyond load factor {:.6g} with steps of {:.3g} or more; the last attempt ended with {}{}",
        state.load_factor, options_.min_step, r.newton.reason, place);
}

}  // namespace voile::solve

#include "voile/solve/static_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "voile/base/error.hpp"
#include "voile/base/interrupt.hpp"
#include "voile/solve/stall.hpp"

namespace voile::solve {

namespace {

/// Halvings in a row before continuation is tried.
constexpr int halvings_before_continuation = 1;

}  // namespace

const char* name(CriticalPoint::Kind kind) {
  switch (kind) {
    case CriticalPoint::Kind::limit:
      return "limit point";
    case CriticalPoint::Kind::bifurcation:
      return "bifurcation point";
    case CriticalPoint::Kind::both:
      break;
  }
  return "limit and bifurcation point";
}

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

double StaticPath::next_target(double from, double step) const {
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
  return target;
}

namespace {

/// From the accepted state to equilibrium at the model's load factor, friction included.
NewtonResult settle(Newton& newton, Vec a, Vec accepted, bool by_continuation) {
  const auto solve = [&] { return by_continuation ? newton.continuation(a) : newton.step(a); };
  VOILE_PETSC(VecCopy(accepted, a));
  newton.start_friction(accepted);
  return newton.settle_friction(a, solve(), solve);
}

}  // namespace

/// Where a run along the path stands.
struct StaticPath::Walk {
  Newton newton;
  petsc::VecHandle accepted;
  PathResult result;
  double factor, step;
  int first_step, halvings = 0;

  Walk(system::Model& model, Vec a, const PathStart& start, double initial_step)
      : newton(model),
        accepted(model.dofs().create_vector()),
        factor(start.load_factor),
        step(initial_step),
        first_step(start.step) {
    VOILE_PETSC(VecCopy(a, accepted));
    result.steps = start.step;
  }
  void tally(const NewtonResult& n) {
    result.newton_iterations += n.iterations;
    result.factorisations += n.factorisations;
  }
};

bool StaticPath::is_final(double factor) const {
  return std::abs(options_.final_load_factor - factor) <= 1e-12 * std::max(1.0, std::abs(options_.final_load_factor));
}

/// One step, tried as Newton's method and, after a halving, by continuation. False if the path ends here.
bool StaticPath::advance(Walk& w, Vec a) {
  const double target = next_target(w.factor, w.step), taken = std::abs(target - w.factor);
  model_.set_load_factor(target);
  NewtonResult n = settle(w.newton, a, w.accepted, false);
  w.tally(n);
  bool by_continuation = false;
  if (!n.converged && options_.fallback && w.halvings == halvings_before_continuation) {
    remark(fmt::format("load factor {:.6g}: {} after {} iterations; trying pseudo-transient continuation", target,
                       n.reason, n.iterations));
    n = settle(w.newton, a, w.accepted, true);
    w.tally(n);
    by_continuation = true;
  }
  if (!n.converged) return halve(w, a, n, target, taken);
  VOILE_PETSC(VecCopy(a, w.accepted));
  w.factor = target;
  ++w.result.steps;
  observe({.step = w.result.steps,
           .load_factor = w.factor,
           .newton = n,
           .by_continuation = by_continuation,
           .last = is_final(w.factor),
           .critical = {}},
          a);
  // A step cut short by a stop says nothing against the step size in force; one after a failure does not grow,
  // unless continuation took it, which does not mind long steps.
  const bool easy = by_continuation || (n.iterations <= options_.target_iterations && w.halvings == 0);
  if (easy && taken > 0.9 * w.step) w.step = std::min(options_.max_step, 2.0 * w.step);
  w.halvings = 0;
  return true;
}

/// After a step that failed. False if the next one would be too small.
bool StaticPath::halve(Walk& w, Vec a, const NewtonResult& n, double target, double taken) {
  const std::string place = 0.5 * taken < options_.min_step ? "; " + largest_residuals_at(model_, a) : "";
  VOILE_PETSC(VecCopy(w.accepted, a));
  ++w.halvings;
  w.step = 0.5 * taken;
  remark(fmt::format("load factor {:.6g}: {} after {} iterations; step halved to {:.3g}", target, n.reason,
                     n.iterations, w.step));
  if (w.step >= options_.min_step) return true;
  w.result.reason = fmt::format(
      "no equilibrium found beyond load factor {:.6g} with steps of {:.3g} or more; the last attempt ended with {}{}",
      w.factor, options_.min_step, n.reason, place);
  return false;
}

PathResult StaticPath::run(Vec a, const PathStart& start) {
  Walk w(model_, a, start, options_.initial_step);
  model_.set_load_factor(w.factor);
  observe({.step = start.step, .load_factor = w.factor, .newton = {}, .critical = {}}, a);
  try {
    while (!is_final(w.factor)) {
      if (w.result.steps - w.first_step >= options_.max_steps) {
        w.result.reason = fmt::format("max_steps = {} steps did not reach the end of the path", options_.max_steps);
        break;
      }
      if (!advance(w, a)) break;
    }
  } catch (const Interrupted& e) {
    VOILE_PETSC(VecCopy(w.accepted, a));
    w.result.reason = e.what();
  }
  w.result.load_factor = w.factor;
  w.result.completed = w.result.reason.empty();
  model_.set_load_factor(w.factor);
  return w.result;
}

}  // namespace voile::solve

#include "time_integration.hpp"

#include <fmt/format.h>
#include <petsc/private/tsimpl.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "alpha_ts.hpp"
#include "base/interrupt.hpp"
#include "base/mpi.hpp"
#include "central_ts.hpp"
#include "linear/inexact_pc.hpp"
#include "stall.hpp"
#include "system/contact.hpp"
#include "time_integration_impl.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

namespace {

constexpr const char* adapt_type = "voile";
/// With contact the acceleration is left out of a first guess where it would fly over more edges than that.
constexpr double longest_flight = 4.0;

/// Whether bending or stretching is damped. Where velocities jump at the start, that balances accelerations which are over long before
/// the end of a step, and by which a step must not go.
bool damps_stiffly(const system::Model& model, const system::DynamicsOptions& options) {
  const auto damps = [](const energy::Material& m) { return m.bending_damping > 0.0 || m.viscous_time > 0.0; };
  const std::vector<energy::Material>& materials = model.discretisation().materials();
  return options.bending_damping > 0.0 || options.viscous_time > 0.0 ||
         (options.material_damping && std::any_of(materials.begin(), materials.end(), damps));
}

/// Whether a rigid body is a straight line, whose masses do not resist a turn about itself: what turns it then accelerates the sheet,
/// and no acceleration follows from the masses alone.
bool turns_without_inertia(const system::Model& model) {
  constexpr double round_off = 1e-9;
  const std::vector<system::BodyMass>& bodies = model.potential().constant().body_mass();
  return std::any_of(bodies.begin(), bodies.end(), [](const system::BodyMass& b) {
    if (!(b.mass > 0.0)) return false;
    const Mat3 about = b.second - b.first * b.first.transpose() / b.mass;
    return about.trace() * about.trace() - (about * about).trace() <= round_off * about.trace() * about.trace();
  });
}

}  // namespace

void TimeIntegration::Impl::create_snes() {
  SNES snes = nullptr;
  KSP ksp = nullptr;
  SNESLineSearch ls = nullptr;
  VOILE_PETSC(TSGetSNES(ts, &snes));
  VOILE_PETSC(SNESSetType(snes, SNESNEWTONLS));
  VOILE_PETSC(SNESSetTolerances(snes, PETSC_DEFAULT, 1e-8, 1e-6, 50, PETSC_MAX_INT));
  VOILE_PETSC(SNESGetLineSearch(snes, &ls));
  VOILE_PETSC(SNESLineSearchSetType(ls, SNESLINESEARCHSHELL));
#if PETSC_VERSION_GE(3, 21, 0)
  VOILE_PETSC(SNESLineSearchShellSetApply(ls, line_search, this));
#else
  VOILE_PETSC(SNESLineSearchShellSetUserFunc(ls, line_search, this));
#endif
  VOILE_PETSC(SNESLineSearchSetPreCheck(ls, before_line_search, this));
  VOILE_PETSC(SNESLineSearchSetPostCheck(ls, after_line_search, this));
  VOILE_PETSC(SNESSetConvergenceTest(snes, converged, this, nullptr));
  VOILE_PETSC(SNESGetKSP(snes, &ksp));
  VOILE_PETSC(KSPSetPostSolve(ksp, after_linear_solve, this));
  linear.set_defaults(ksp, inexact ? linear::LinearSolver::Method::inexact : linear::LinearSolver::Method::mixed);
}

void TimeIntegration::Impl::create(const system::State& from) {
  register_alpha_ts();
  register_central_ts();
  VOILE_PETSC(TSAdaptRegister(adapt_type, [](TSAdapt adapt) -> PetscErrorCode {
    adapt->ops->choose = choose;
    return 0;
  }));
  VOILE_PETSC(TSCreate(model.dofs().comm(), ts.out()));
  VOILE_PETSC(TSSetProblemType(ts, TS_NONLINEAR));
  VOILE_PETSC(
      TSSetType(ts, options.method == TimeOptions::Method::central_difference ? central_ts_type : alpha_ts_type));
  VOILE_PETSC(TS2SetSolution(ts, from.u, from.v));
  VOILE_PETSC(TSSetI2Function(ts, nullptr, function, this));
  VOILE_PETSC(TSSetI2Jacobian(ts, model.tangent().matrix(), model.tangent().matrix(), jacobian, this));
  VOILE_PETSC(TSSetTime(ts, from.time));
  VOILE_PETSC(TSSetStepNumber(ts, from.step));
  VOILE_PETSC(TSSetMaxTime(ts, until()));
  VOILE_PETSC(TSSetMaxSteps(ts, PETSC_MAX_INT));
  VOILE_PETSC(TSSetTimeStep(ts, by_motions(from.time, from.next_step > 0.0 ? from.next_step : options.step)));
  VOILE_PETSC(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  VOILE_PETSC(TSSetMaxSNESFailures(ts, -1));
  VOILE_PETSC(TSSetMaxStepRejections(ts, 20));
  VOILE_PETSC(TSSetErrorIfStepFails(ts, PETSC_FALSE));
  if (options.step_error > 0.0) VOILE_PETSC(TSSetTolerances(ts, options.step_error, nullptr, 0.0, nullptr));
  TSAdapt adapt = nullptr;
  VOILE_PETSC(TSGetAdapt(ts, &adapt));
  VOILE_PETSC(TSAdaptSetType(adapt, adapt_type));
  adapt->data = this;
  // PETSc wants the two to differ, but a fixed step is legal.
  VOILE_PETSC(TSAdaptSetStepLimits(adapt, options.min_step * (1.0 - 1e-9), options.max_step));
  PetscBool implicit = PETSC_FALSE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(static_cast<TS>(ts)), alpha_ts_type, &implicit));
  if (implicit) set_alpha_radius(ts, options.radius);
  create_snes();
  refuse_snes_options();
  VOILE_PETSC(TSSetFromOptions(ts));
  // -ts_max_time is known to the caller, who may want to stop earlier.
  PetscReal max_time = 0.0;
  VOILE_PETSC(TSGetMaxTime(ts, &max_time));
  if (max_time != until()) options.end_time = std::min(options.end_time, static_cast<double>(max_time));
  VOILE_PETSC(TSSetMaxTime(ts, until()));
}

/// What -ts_type finally is decides about callbacks and the start.
void TimeIntegration::Impl::choose_method(const system::State& from) {
  const auto is = [&](const char* type) {
    PetscBool same = PETSC_FALSE;
    VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(static_cast<TS>(ts)), type, &same));
    return same == PETSC_TRUE;
  };
  explicit_method = is(central_ts_type);
  if (!explicit_method && !is(alpha_ts_type)) throw UserError("-ts_type must be voile_alpha or voile_central");
  if (explicit_method && model.contact())
    throw UserError("contact needs the implicit method, -ts_type voile_alpha: its barrier holds at the end of a step");
  const bool rigid = !model.discretisation().constraints().bodies.empty();
  if (explicit_method && rigid) throw UserError("[[rigid]] groups need the implicit method, -ts_type voile_alpha");
  constexpr double most_with_bodies = 0.9;
  if (rigid && alpha_radius(ts) > most_with_bodies)
    throw UserError("-ts_voile_radius: with [[rigid]] groups oscillations would grow; 0.9 at most");
  if (explicit_method) {
    if (dynamics.options().mass == system::Mass::consistent)
      throw UserError("the explicit method needs mass = \"lumped\"");
    set_central_callbacks(ts, {this, accelerate, enforce, prescribe});
    if (from.a) set_central_acceleration(ts, from.a);
    set_explicit_step(from);
    VOILE_PETSC(VecCopy(from.u, start));
    dynamics.start_step(from.u, from.v, options.step);
    if (!remembers_start()) return;
    set_start(coming, from.u, from.v, from.time, options.step);
    if (!from.a || !from.last.u) return;
    // Of an unbroken motion it begins with the velocity that the step before had in its middle.
    coming.size = from.time - from.last.time;
    VOILE_PETSC(VecAXPY(coming.v, -0.5 * coming.size, from.a));
    return;
  }
  const bool contact = model.contact() != nullptr, damped = damps_stiffly(model, dynamics.options());
  set_alpha_callbacks(
      ts, {this, start_step, enforce, prescribe, contact ? clear : nullptr,
           contact && model.conditions().symmetric() ? energy : nullptr,
           contact ? longest_flight * contact::mean_edge(model.contact()->scene().set().surface()) : 0.0,
           account ? accepted : nullptr,
           (contact && inexact) || damped || turns_without_inertia(model),  // falls of a drape start from other states
           damped, exactly, solved});
  linear.prepare();
  prepare_inexact(from.solver);
  read_solver_choice();
  if (const double radius = alpha_radius(ts); contact && radius > 0.0 && remark)
    remark(
        fmt::format("warning: radius = {:g} with contact: what hits something in one step can leave it with {:g} times "
                    "its speed; 0, the default, gains nothing",
                    radius, 1.0 + 2.0 * radius));
  if (from.a) set_acceleration(ts, from.a);
}

/// What the options of the SNES finally are.
void TimeIntegration::Impl::read_solver_choice() {
  SNES snes = nullptr;
  SNESLineSearch search = nullptr;
  PetscBool ours = PETSC_FALSE;
  VOILE_PETSC(TSGetSNES(ts, &snes));
  VOILE_PETSC(SNESSetConvergenceTest(snes, converged, this, nullptr));  // an option may have put another in its place
  test.read(snes);
  choice.read(snes, model.contact() != nullptr);
  if (!choice.is_current()) linear.expect_stale_factor();
  VOILE_PETSC(SNESGetLineSearch(snes, &search));
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(search), SNESLINESEARCHSHELL, &ours));
  own_search = ours == PETSC_TRUE;
}

std::string TimeIntegration::Impl::place_of_failure() {
  if (explicit_method) return "";
  SNES snes = nullptr;
  Vec r = nullptr;
  VOILE_PETSC(TSGetSNES(ts, &snes));
  VOILE_PETSC(SNESGetFunction(snes, &r, nullptr, nullptr));
  return r ? "; " + largest_residuals(dynamics.model(), r) : "";
}

void TimeIntegration::Impl::note_effort(StepResult& r) {
  PetscInt rejections = 0;
  VOILE_PETSC(TSGetStepRejections(ts, &rejections));
  r.rejections = static_cast<int>(rejections) - spent_rejections;
  spent_rejections = static_cast<int>(rejections);
  r.factorisations = linear.factorisations() - spent_factorisations;
  spent_factorisations = linear.factorisations();
  PC pc = linear.inexact();
  if (!pc) return;
  const linear::InexactCounts& c = linear::inexact_counts(pc);
  const IterativeEffort before =
      std::exchange(spent_iterative, {c.solutions, c.iterations, c.shifted, c.negative_curvature});
  r.iterative = {c.solutions - before.solutions, c.iterations - before.iterations, c.shifted - before.shifted,
                 c.negative_curvature - before.negative_curvature};
}

void TimeIntegration::Impl::accept(system::State& state, StepResult& r) {
  PetscInt step = 0, iterations = 0;
  double before = 0.0;
  VOILE_PETSC(TSGetPrevTime(ts, &before));
  VOILE_PETSC(TSGetTime(ts, &state.time));
  VOILE_PETSC(TSGetStepNumber(ts, &step));
  r.taken = last_taken = state.time - before;
  state.step = static_cast<int>(step);
  r.newton.converged = true;
  r.cut_short = cuts;
  r.shortest = shortest;
  note_effort(r);
  r.newton.factorisations = r.factorisations;
  if (!state.a) state.a = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(explicit_method ? central_acceleration(ts) : acceleration(ts), state.a));
  if (!explicit_method) {
    SNES snes = nullptr;
    VOILE_PETSC(TSGetSNES(ts, &snes));
    VOILE_PETSC(SNESGetIterationNumber(snes, &iterations));
    r.newton.residual = residual;
    r.newton.negative_pivots = linear.negative_pivots();
  }
  r.newton.iterations = r.newton_iterations = static_cast<int>(iterations);
  if (explicit_method) keep_stability(state);
  // The size that was wanted, not what was left of it before the end.
  VOILE_PETSC(TSGetTimeStep(ts, &state.next_step));
  if (is_end(state.time)) state.time = until();
  if (ended() && wanted > 0.0) state.next_step = wanted;
  dynamics.set_time(state.time);
  if (account && explicit_method) account->end_step(state.u, state.v, before, state.time);
  if (account) state.balance = account->balance();
  model.potential().end_step(state.u);
  if (model.conditions().has_gas()) {
    model.conditions().end_leaks(model.potential().configuration(state.u), state.time);
    if (account && !model.conditions().leaks().empty()) account->renew(state.u, state.v, state.a);
  }
  state.load_factor = model.conditions().load_factor();
  if (model.contact()) state.contact = model.contact()->memory();
  state.solver = solver_memory();
  state.in_equilibrium = false;
  if (!under_way.u) return;
  set_start(state.last, under_way.u, under_way.v, under_way.time, under_way.size);
}

bool TimeIntegration::Impl::remembers_start() const {
  return damps_stiffly(model, dynamics.options()) || dynamics.options().drag.active();
}

/// The state stays the last accepted one.
void TimeIntegration::Impl::fail(system::State& state, StepResult& r, TSConvergedReason reason) {
  r.outcome = Outcome::failed;
  note_effort(r);
  // Obstacles are still where the step that failed wanted to go.
  dynamics.set_time(state.time);
  if (model.contact()) model.contact()->restore(state.contact);
  // The size that failed is no size to go on with.
  state.next_step = last_taken > 0.0 ? last_taken : options.step;
  if (reason == TSFORWARD_DIVERGED_LINEAR_SOLVE) {
    r.reason = fmt::format(
        "no acceleration follows from the forces and masses at t = {:.6g} s with steps of {:g} s; check "
        "the values of [[load]], [[support]], [[material]], [damping] and [time]",
        state.time, options.step);
    return;
  }
  if (explicit_method) {
    r.reason = fmt::format(
        "central differences have become unstable at t = {:.6g} s with steps of {:.3g} s, below the stability limit of "
        "{:.3g} s before it: the sheet stiffens within a step; give a smaller time.step, or method = \"alpha\"",
        state.time, last_taken > 0.0 ? last_taken : options.max_step, 2.0 / stability.memory.frequency);
    return;
  }
  r.reason = fmt::format("{} at t = {:.6g} s: no step of {:.3g} s or more succeeds", TSConvergedReasons[reason],
                         state.time, options.min_step) +
             (obstruction.empty() ? "" : "; in the way was " + obstruction) + place_of_failure() +
             largest_stretch(dynamics.model(), state.u);
}

bool TimeIntegration::Impl::ended() const {
  TSConvergedReason reason = TS_CONVERGED_ITERATING;
  VOILE_PETSC(TSGetConvergedReason(ts, &reason));
  return reason != TS_CONVERGED_ITERATING;
}

/// The next step has this size, or what is left of it before the end.
void TimeIntegration::Impl::meet_end(double time, double step) {
  const double left = until() - time;
  const bool meets = step >= left || std::abs(step - left) <= 10.0 * PETSC_MACHINE_EPSILON * std::abs(left);
  VOILE_PETSC(TSSetTimeStep(ts, meets && left > 0.0 ? left : step));
}

/// As TSSolve does before its first step.
void TimeIntegration::Impl::prepare_first_step(const system::State& state) {
  double h = 0.0;
  PetscInt most = 0;
  VOILE_PETSC(TSSetUp(ts));
  VOILE_PETSC(TSGetTimeStep(ts, &h));
  first_step = h;
  const double left = until() - state.time;
  meet_end(state.time, h);
  VOILE_PETSC(TSRestartStep(ts));
  VOILE_PETSC(TSGetMaxSteps(ts, &most));
  TSConvergedReason reason = TS_CONVERGED_ITERATING;
  if (state.step >= most)
    reason = TS_CONVERGED_ITS;
  else if (left <= 0.0)
    reason = TS_CONVERGED_TIME;
  VOILE_PETSC(TSSetConvergedReason(ts, reason));
  if (!options.goes_on) VOILE_PETSC(TSMonitor(ts, state.step, state.time, state.u));
}

/// -ts_view and -ts_view_solution, as TSSolve shows them when it ends.
void TimeIntegration::Impl::view_at_end(const system::State& state) {
  if (ended() && is_end(state.time) && until() < options.end_time) return;  // another continues from here
  VOILE_PETSC(TSViewFromOptions(ts, nullptr, "-ts_view"));
  VOILE_PETSC(VecViewFromOptions(state.u, reinterpret_cast<PetscObject>(static_cast<TS>(ts)), "-ts_view_solution"));
}

TimeIntegration::TimeIntegration(system::Dynamics& dynamics, TimeOptions options, bool inexact)
    : impl_(std::make_unique<Impl>(dynamics, options, remarks(), inexact)) {}
TimeIntegration::~TimeIntegration() = default;

StepResult TimeIntegration::begin(system::State& state) {
  Impl& n = *impl_;
  if (!state.v) state.v = n.model.dofs().create_vector();
  n.dynamics.set_time(state.time);
  n.model.conditions().enforce(state.u);
  n.dynamics.prescribe_rates({state.time, n.options.step, n.options.end_time},
                             !n.options.goes_on && !n.options.restarted, state.v);
  if (n.model.conditions().has_gas())
    n.model.conditions().begin_leaks(n.model.potential().configuration(state.u), state.time);
  if (state.last.u && n.remembers_start()) n.dynamics.resume_step(state.last);
  if (n.options.energy_balance) {
    n.account.emplace(n.dynamics, system::short_moment * n.options.step)
        .begin(state.u, state.v, state.a, state.balance, n.options.restarted && !n.options.released);
    state.balance = n.account->balance();
  }
  n.create(state);
  n.choose_method(state);
  if (n.explicit_method && state.last.u && n.remembers_start()) n.dynamics.resume_step(state.last);
  n.prepare_first_step(state);
  n.dynamics.set_time(state.time);
  state.load_factor = n.model.conditions().load_factor();
  if (n.model.contact()) state.contact = n.model.contact()->memory();
  return {};
}

bool TimeIntegration::finished(const system::State&) const {
  return impl_->ended();
}

void TimeIntegration::end_at(const system::State& state, double time) {
  Impl& n = *impl_;
  n.options.until = time;
  VOILE_PETSC(TSSetMaxTime(n.ts, n.until()));
  VOILE_PETSC(TSSetTime(n.ts, state.time));
  n.meet_end(state.time, n.wanted > 0.0 ? n.by_motions(state.time, n.wanted) : n.first_step);
  TSConvergedReason reason = TS_CONVERGED_ITERATING;
  VOILE_PETSC(TSGetConvergedReason(n.ts, &reason));
  if (reason == TS_CONVERGED_TIME && state.time < n.until())
    VOILE_PETSC(TSSetConvergedReason(n.ts, TS_CONVERGED_ITERATING));
}

StepResult TimeIntegration::advance(system::State& state) {
  Impl& n = *impl_;
  StepResult r;
  try {
    TSConvergedReason reason = TS_CONVERGED_ITERATING;
    VOILE_PETSC(TSPreStep(n.ts));
    VOILE_PETSC(TSStep(n.ts));
    VOILE_PETSC(TSGetConvergedReason(n.ts, &reason));
    if (reason < 0)
      n.fail(state, r, reason);
    else
      n.accept(state, r);
    VOILE_PETSC(TSMonitor(n.ts, state.step, state.time, state.u));
    if (reason == TS_CONVERGED_ITS && !n.is_end(state.time)) {
      r.outcome = Outcome::failed;
      r.worth_keeping = true;
      r.reason =
          fmt::format("-ts_max_steps ends the motion at t = {:.6g} s, before t = {:.6g} s", state.time, n.until());
    }
    if (reason != TS_CONVERGED_ITERATING) n.view_at_end(state);
  } catch (const Interrupted& e) {
    if (!n.explicit_method) abandon_step(n.ts);
    n.note_effort(r);
    n.dynamics.set_time(state.time);
    r.outcome = Outcome::failed;
    r.interrupted = true;
    r.reason = e.what();
  }
  return r;
}

}  // namespace voile::solve

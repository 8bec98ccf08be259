#include "voile/solve/time_integration.hpp"

#include <fmt/format.h>
#include <petsc/private/tsimpl.h>
#include <petscts.h>

#include <algorithm>
#include <cmath>

#include "contact_way.hpp"
#include "voile/base/error.hpp"
#include "voile/base/interrupt.hpp"
#include "voile/base/mpi.hpp"
#include "voile/solve/alpha_ts.hpp"
#include "voile/solve/central_ts.hpp"
#include "voile/solve/inverse_iteration.hpp"
#include "voile/solve/stall.hpp"

namespace voile::solve {

namespace {

using TsHandle = petsc::Handle<TS, TSDestroy>;

constexpr const char* adapt_type = "voile";
constexpr double sufficient_decrease = 1e-4, shortest_length = 1e-6;
/// Share of the first step below which an obstacle may give way to what it pinches.
constexpr double pinched_step = 0.1;
/// Relative size at which a change of the energy is lost in its round-off.
constexpr double energy_round_off = 1e-12;
/// After an indefinite tangent so many positive ones are taken before the exact one is tried again. A sheet in contact
/// is full of wrinkles about to form, and the positive tangent is as good there.
constexpr int positive_tangents = 4, positive_tangents_in_contact = 40;

}  // namespace

struct TimeIntegration::Impl {
  system::Dynamics& dynamics;
  system::Model& model;
  TimeOptions options;
  Observer observer;
  Remark remark;
  TsHandle ts;
  LinearSolver linear;
  ConvergenceTest test;
  petsc::VecHandle trial, start, product;
  TimeResult result;
  double residual_before = 0.0, work = 0.0, rms = -1.0, length = 1.0, residual = 0.0;
  bool cut = false;  ///< contact did not let the last iteration go the whole way
  int cuts = 0;      ///< iterations of this step for which that holds
  double shortest = 1.0;
  std::string obstruction;
  double last_taken = 0.0;  ///< size of the last accepted step [s]
  double wanted = 0.0;      ///< size of the next step, which PETSc may cut to meet the end [s]
  int positive_left = 0, spent_factorisations = 0, spent_rejections = 0, first_step = 0;
  bool explicit_method = false;

  Impl(system::Dynamics& d, TimeOptions o) : dynamics(d), model(d.model()), options(o), linear(model), test(model) {
    for (petsc::VecHandle* v : {&trial, &start, &product}) *v = model.dofs().create_vector();
    if (options.max_step == 0.0) options.max_step = options.step;
    if (options.min_step == 0.0) options.min_step = 1e-3 * options.step;
  }

  void create(const TimeState& from);
  void create_snes();
  void set_explicit_step(Vec u);
  [[nodiscard]] double objective(Vec x);
  [[nodiscard]] bool clear_way(double t0, Vec x0, double t1, Vec x1);
  void search(SNESLineSearch line_search);
  /// Where the last solve left the largest residuals, in words. Collective.
  [[nodiscard]] std::string place_of_failure();
  [[nodiscard]] SNESConvergedReason judge(SNES snes, PetscInt it, double increment, double norm);
  [[nodiscard]] double next_step(double h, PetscBool* accept, PetscReal* error);
  void report(PetscInt step, PetscReal time);
  void finish(const TimeState& from);
  /// The sum of many steps may miss the end by its round-off.
  [[nodiscard]] bool is_end(double time) const {
    return std::abs(time - options.end_time) <= 1e-12 * std::max(1.0, std::abs(options.end_time));
  }

  static PetscErrorCode function(TS, PetscReal t, Vec u, Vec v, Vec a, Vec f, void* self);
  static PetscErrorCode jacobian(TS, PetscReal t, Vec u, Vec v, Vec a, PetscReal s_v, PetscReal s_a, Mat, Mat,
                                 void* self);
  static PetscErrorCode start_step(void* self, Vec x, Vec v, PetscReal step);
  static PetscErrorCode enforce(void* self, PetscReal t, Vec stage);
  static PetscErrorCode clear(void* self, PetscReal t0, Vec x0, PetscReal t1, Vec x1, PetscBool* possible);
  static PetscErrorCode energy(void* self, Vec x1, PetscReal* value);
  static PetscErrorCode accelerate(void* self, PetscReal t, Vec x, Vec v, Vec a);
  static PetscErrorCode line_search(SNESLineSearch ls, void* self);
  static PetscErrorCode converged(SNES, PetscInt it, PetscReal, PetscReal snorm, PetscReal fnorm,
                                  SNESConvergedReason* reason, void* self);
  static PetscErrorCode post_step(TS ts);
  static PetscErrorCode choose(TSAdapt adapt, TS ts, PetscReal h, PetscInt* scheme, PetscReal* next, PetscBool* accept,
                               PetscReal* error, PetscReal* absolute, PetscReal* relative);
};

// ---- callbacks -----------------------------------------------------------------------------------------------------

PetscErrorCode TimeIntegration::Impl::function(TS, PetscReal t, Vec u, Vec v, Vec a, Vec f, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    n.dynamics.set_time(t);
    n.dynamics.residual(u, v, a, f);
  });
}

PetscErrorCode TimeIntegration::Impl::jacobian(TS, PetscReal t, Vec u, Vec, Vec, PetscReal s_v, PetscReal s_a, Mat, Mat,
                                               void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    n.dynamics.set_time(t);
    const auto assemble = [&](energy::Tangent kind) {
      n.dynamics.assemble_tangent(u, kind, s_v, s_a);
      n.linear.tangent_changed();
      return n.linear.factorise();
    };
    if (n.positive_left > 0) {
      --n.positive_left;
      (void)assemble(energy::Tangent::positive);
    } else if (!assemble(energy::Tangent::exact) || n.linear.negative_pivots() > 0) {
      n.positive_left = n.model.contact() ? positive_tangents_in_contact : positive_tangents;
      (void)assemble(energy::Tangent::positive);
    }
  });
}

PetscErrorCode TimeIntegration::Impl::start_step(void* self, Vec x, Vec v, PetscReal step) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    double t = 0.0;
    VOILE_PETSC(TSGetTime(n.ts, &t));
    n.dynamics.set_time(t);
    n.dynamics.start_step(x, v, step);
    VOILE_PETSC(VecCopy(x, n.start));
    n.model.count_energy_from(x);  // so that a restart chooses its first guess by the same figures
    if (!n.model.contact()) n.positive_left = 0;
    n.cuts = 0;
    n.shortest = 1.0;
  });
}

PetscErrorCode TimeIntegration::Impl::enforce(void* self, PetscReal t, Vec stage) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    n.dynamics.set_time(t);
    n.model.enforce_supports(stage);
  });
}

PetscErrorCode TimeIntegration::Impl::accelerate(void* self, PetscReal t, Vec x, Vec v, Vec a) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    double h = 0.0;
    VOILE_PETSC(TSGetTimeStep(n.ts, &h));
    n.dynamics.set_time(t);
    VOILE_PETSC(VecZeroEntries(a));
    n.dynamics.residual(x, v, a, n.trial);
    n.dynamics.start_step(x, v, h);  // drag and viscosity of the next half step
    n.model.dofs().clear_fixed(n.trial);
    VOILE_PETSC(VecPointwiseDivide(a, n.trial, n.model.mass()));
    VOILE_PETSC(VecScale(a, -1.0));
  });
}

bool TimeIntegration::Impl::clear_way(double t0, Vec x0, double t1, Vec x1) {
  system::Contact& contact = *model.contact();
  bool clear = contact.make_way(x0, t0, x1, t1);
  if (!clear) {  // a guess that flies on may be worse than none
    dynamics.set_time(t1);
    VOILE_PETSC(VecCopy(x0, x1));
    model.enforce_supports(x1);
    // Only what is still blocked in small steps is pinched.
    const bool may_yield = t1 - t0 <= std::max(pinched_step * options.step, 2.0 * options.min_step);
    const long before = contact.yielding_count();
    clear = contact.make_way(x0, t0, x1, t1, may_yield);
    if (clear && contact.yielding_count() > before && before == 0 && remark)
      remark(fmt::format("t = {:.6g} s: an obstacle gives way to {} vertices; {} was pinched", t0,
                         contact.yielding_count(), contact.obstruction()));
  }
  if (!clear) obstruction = contact.obstruction();
  dynamics.set_time(t1);
  return clear;
}

PetscErrorCode TimeIntegration::Impl::clear(void* self, PetscReal t0, Vec x0, PetscReal t1, Vec x1,
                                            PetscBool* possible) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { *possible = n.clear_way(t0, x0, t1, x1) ? PETSC_TRUE : PETSC_FALSE; });
}

PetscErrorCode TimeIntegration::Impl::energy(void* self, Vec x1, PetscReal* value) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { *value = n.objective(x1); });
}

double TimeIntegration::Impl::objective(Vec x) {
  const AlphaStage s = alpha_stage(ts, x);
  return dynamics.energy(s.x, s.v, s.a, s.s_v, s.s_a) / (s.a_f * s.a_f);
}

/// Backtracking on the incremental potential; full steps where there is none (follower loads).
void TimeIntegration::Impl::search(SNESLineSearch ls) {
  SNES snes = nullptr;
  Vec x = nullptr, f = nullptr, y = nullptr;
  VOILE_PETSC(SNESLineSearchGetSNES(ls, &snes));
  VOILE_PETSC(SNESLineSearchGetVecs(ls, &x, &f, &y, nullptr, nullptr));
  double slope = 0.0, norm = 0.0;
  VOILE_PETSC(VecDot(f, y, &slope));
  VOILE_PETSC(VecNorm(f, NORM_2, &norm));
  work = slope;
  length = longest_share(model, x, y, trial);
  cut = length < 1.0;
  cuts += cut ? 1 : 0;
  if (model.symmetric()) {
    model.count_energy_from(alpha_stage(ts, x).x);
    const double before = objective(x);
    for (;; length *= 0.5) {
      VOILE_PETSC(VecWAXPY(trial, -length, y, x));
      const double after = objective(trial);
      if (std::isfinite(after) && after <= before - sufficient_decrease * length * slope) break;
      if (std::isfinite(after) && std::abs(after - before) <= energy_round_off * std::abs(before)) {
        // Too small a change to be seen in the energy: the forces decide.
        VOILE_PETSC(SNESComputeFunction(snes, trial, f));
        double reduced = 0.0;
        VOILE_PETSC(VecNorm(f, NORM_2, &reduced));
        if (reduced <= norm) break;
      }
      if (length < shortest_length) {
        VOILE_PETSC(SNESLineSearchSetReason(ls, SNES_LINESEARCH_FAILED_REDUCT));
        return;
      }
    }
  }
  shortest = std::min(shortest, length);
  VOILE_PETSC(VecAXPY(x, -length, y));
  VOILE_PETSC(VecPointwiseMult(product, model.mass(), y));
  double square = 0.0, mass = 0.0;
  VOILE_PETSC(VecDot(product, y, &square));
  VOILE_PETSC(VecSum(model.mass(), &mass));
  rms = length * std::sqrt(3.0 * square / mass);
  VOILE_PETSC(SNESComputeFunction(snes, x, f));
  VOILE_PETSC(SNESLineSearchSetLambda(ls, length));
  VOILE_PETSC(SNESLineSearchComputeNorms(ls));
}

PetscErrorCode TimeIntegration::Impl::line_search(SNESLineSearch ls, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { n.search(ls); });
}

SNESConvergedReason TimeIntegration::Impl::judge(SNES snes, PetscInt it, double increment, double norm) {
  stop_if_asked(model.comm());
  if (!std::isfinite(norm)) return SNES_DIVERGED_FNORM_NAN;
  const double force = dynamics.force_scale(), before = std::exchange(residual_before, norm);
  residual = force > 0.0 ? norm / force : norm;
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
  if (length == 1.0 && rms <= options.velocity_tolerance * h) return SNES_CONVERGED_SNORM_RELATIVE;
  const SNESConvergedReason reason = test.judge({norm, before, force, increment, step, work});
  if (reason != SNES_CONVERGED_ITERATING) return reason;
  return it >= test.max_iterations() ? SNES_DIVERGED_MAX_IT : SNES_CONVERGED_ITERATING;
}

PetscErrorCode TimeIntegration::Impl::converged(SNES snes, PetscInt it, PetscReal, PetscReal snorm, PetscReal fnorm,
                                                SNESConvergedReason* reason, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { *reason = n.judge(snes, it, it > 0 ? snorm : -1.0, fnorm); });
}

// ---- step size -----------------------------------------------------------------------------------------------------

double TimeIntegration::Impl::next_step(double h, PetscBool* accept, PetscReal* error) {
  *accept = PETSC_TRUE;
  *error = -1.0;
  double factor = 2.0;
  if (!explicit_method) {
    SNES snes = nullptr;
    PetscInt iterations = 0;
    VOILE_PETSC(TSGetSNES(ts, &snes));
    VOILE_PETSC(SNESGetIterationNumber(snes, &iterations));
    factor = std::clamp(static_cast<double>(options.target_iterations) / std::max<PetscInt>(1, iterations), 0.5, 1.5);
    if (options.step_error > 0.0) {
      VOILE_PETSC(TSEvaluateWLTE(ts, NORM_INFINITY, nullptr, error));
      factor = std::min(factor, 0.9 / std::cbrt(std::max(*error, 1e-3)));
      if (*error > 1.0 && h > options.min_step) *accept = PETSC_FALSE;
    }
  }
  PetscInt rejections = 0;
  VOILE_PETSC(TSGetStepRejections(ts, &rejections));
  // A step that was only cut to meet the end says nothing against the size that was wanted.
  const bool only_cut = *accept && h < 0.999 * wanted && rejections == spent_rejections;
  const double next = std::clamp(factor * h, options.min_step, options.max_step);
  return wanted = only_cut ? std::max(next, wanted) : next;
}

PetscErrorCode TimeIntegration::Impl::choose(TSAdapt adapt, TS, PetscReal h, PetscInt* scheme, PetscReal* next,
                                             PetscBool* accept, PetscReal* error, PetscReal* absolute,
                                             PetscReal* relative) {
  auto& n = *static_cast<Impl*>(adapt->data);
  *scheme = 0;
  *absolute = *relative = -1.0;
  return petsc::guarded([&] { *next = n.next_step(h, accept, error); });
}

// ---- set-up and run ------------------------------------------------------------------------------------------------

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
  VOILE_PETSC(SNESSetConvergenceTest(snes, converged, this, nullptr));
  VOILE_PETSC(SNESGetKSP(snes, &ksp));
  linear.set_defaults(ksp, model.contact() ? LinearSolver::Precision::mixed : LinearSolver::Precision::full);
}

void TimeIntegration::Impl::set_explicit_step(Vec u) {
  double h = 0.0;
  VOILE_PETSC(TSGetTimeStep(ts, &h));
  const double limit = 2.0 / largest_frequency(dynamics, u);
  if (remark) remark(fmt::format("central differences: stability limit {:.4g} s", limit));
  options.max_step = std::min(options.max_step, 0.9 * limit);
  options.min_step = std::min(options.min_step, options.max_step);
  if (h <= options.max_step) return;
  if (remark) remark(fmt::format("step reduced from {:.4g} s to {:.4g} s", h, options.max_step));
  VOILE_PETSC(TSSetTimeStep(ts, options.max_step));
}

void TimeIntegration::Impl::create(const TimeState& from) {
  register_alpha_ts();
  register_central_ts();
  VOILE_PETSC(TSAdaptRegister(adapt_type, [](TSAdapt adapt) -> PetscErrorCode {
    adapt->ops->choose = choose;
    return 0;
  }));
  VOILE_PETSC(TSCreate(model.comm(), ts.out()));
  VOILE_PETSC(TSSetProblemType(ts, TS_NONLINEAR));
  VOILE_PETSC(
      TSSetType(ts, options.method == TimeOptions::Method::central_difference ? central_ts_type : alpha_ts_type));
  VOILE_PETSC(TS2SetSolution(ts, from.position, from.velocity));
  VOILE_PETSC(TSSetI2Function(ts, nullptr, function, this));
  VOILE_PETSC(TSSetI2Jacobian(ts, model.tangent_matrix(), model.tangent_matrix(), jacobian, this));
  VOILE_PETSC(TSSetTime(ts, from.time));
  VOILE_PETSC(TSSetStepNumber(ts, from.step));
  VOILE_PETSC(TSSetMaxTime(ts, options.end_time));
  VOILE_PETSC(TSSetMaxSteps(ts, PETSC_MAX_INT));
  VOILE_PETSC(TSSetTimeStep(ts, from.next_step > 0.0 ? from.next_step : options.step));
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
  if (implicit) set_alpha_parameters(ts, options.radius, options.forces_at_end);
  if (model.contact() && !(implicit && options.forces_at_end))
    throw UserError(
        "contact needs the implicit method with forces_at_end = true: its barrier holds at the end of a step");
  create_snes();
  VOILE_PETSC(TSSetFromOptions(ts));
  // -ts_max_time is known to the caller (read_time_options), who may want to stop earlier.
  PetscReal max_time = 0.0;
  VOILE_PETSC(TSGetMaxTime(ts, &max_time));
  options.end_time = std::min(options.end_time, static_cast<double>(max_time));
  VOILE_PETSC(TSSetMaxTime(ts, options.end_time));
  VOILE_PETSC(TSSetApplicationContext(ts, this));
  VOILE_PETSC(TSSetPostStep(ts, post_step));
}

/// What -ts_type finally is decides about callbacks and the start.
TimeResult TimeIntegration::run(const TimeState& from) {
  Impl& n = *impl_;
  n.result = {};
  n.first_step = from.step;
  n.dynamics.set_time(from.time);
  n.model.enforce_supports(from.position);
  n.create(from);
  PetscBool alpha = PETSC_FALSE, central = PETSC_FALSE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(static_cast<TS>(n.ts)), alpha_ts_type, &alpha));
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(static_cast<TS>(n.ts)), central_ts_type, &central));
  if (!alpha && !central) throw UserError("-ts_type must be voile_alpha or voile_central");
  n.explicit_method = central;
  if (alpha) {
    const bool contact = n.model.contact() != nullptr;
    set_alpha_callbacks(n.ts, {&n, Impl::start_step, Impl::enforce, contact ? Impl::clear : nullptr,
                               contact && n.model.symmetric() ? Impl::energy : nullptr});
    n.linear.prepare();
    SNES snes = nullptr;
    VOILE_PETSC(TSGetSNES(n.ts, &snes));
    n.test.read(snes);
    if (n.model.contact() && n.options.radius > 0.5 && n.remark)
      n.remark(
          fmt::format("warning: radius = {:g} with contact: impacts can feed energy into what is hardly damped; 0.5 "
                      "or less is safe",
                      n.options.radius));
    if (from.acceleration) set_acceleration(n.ts, from.acceleration);
  } else {
    if (n.dynamics.options().mass == system::Mass::consistent)
      throw UserError("the explicit method needs mass = \"lumped\"");
    set_central_callbacks(n.ts, {&n, Impl::accelerate, Impl::enforce});
    n.set_explicit_step(from.position);
    n.dynamics.start_step(from.position, from.velocity, n.options.step);
  }
  n.report(from.step, from.time);
  try {
    if (!n.result.stopped) VOILE_PETSC(TSSolve(n.ts, nullptr));
  } catch (const Interrupted& e) {
    if (alpha) abandon_step(n.ts);
    n.result.stopped = true;
    n.result.reason = e.what();
  }
  n.finish(from);
  return n.result;
}

/// The last accepted state, and why there is none after it.
void TimeIntegration::Impl::finish(const TimeState& from) {
  TSConvergedReason reason = TS_CONVERGED_ITERATING;
  PetscInt steps = 0;
  VOILE_PETSC(TSGetConvergedReason(ts, &reason));
  VOILE_PETSC(TSGetStepNumber(ts, &steps));
  TimeState& state = result.state;
  VOILE_PETSC(TSGetTime(ts, &state.time));
  VOILE_PETSC(TSGetTimeStep(ts, &state.next_step));
  VOILE_PETSC(TS2GetSolution(ts, &state.position, &state.velocity));
  if (!explicit_method) state.acceleration = acceleration(ts);
  if (is_end(state.time)) state.time = options.end_time;
  state.step = static_cast<int>(steps);
  result.steps = static_cast<int>(steps) - from.step;
  result.rejections = spent_rejections;
  result.factorisations = linear.factorisations();
  result.completed = reason > 0;
  if (result.completed && wanted > 0.0) state.next_step = wanted;
  if (result.completed || result.stopped) return;
  // The size that failed is no size to go on with.
  state.next_step = last_taken > 0.0 ? last_taken : options.step;
  result.reason = fmt::format("{} at t = {:.6g} s: no step of {:.3g} s or more succeeds", TSConvergedReasons[reason],
                              state.time, options.min_step) +
                  (obstruction.empty() ? "" : "; in the way was " + obstruction) + place_of_failure();
}

std::string TimeIntegration::Impl::place_of_failure() {
  if (explicit_method) return "";
  SNES snes = nullptr;
  Vec r = nullptr;
  VOILE_PETSC(TSGetSNES(ts, &snes));
  VOILE_PETSC(SNESGetFunction(snes, &r, nullptr, nullptr));
  return r ? "; " + largest_residuals(dynamics.model(), r) : "";
}

void TimeIntegration::Impl::report(PetscInt step, PetscReal time) {
  TimeReport r;
  r.state.step = static_cast<int>(step);
  r.state.time = time;
  VOILE_PETSC(TS2GetSolution(ts, &r.state.position, &r.state.velocity));
  VOILE_PETSC(TSGetTimeStep(ts, &r.state.next_step));
  if (is_end(time)) r.state.time = options.end_time;
  if (step > first_step) {
    double before = 0.0;
    VOILE_PETSC(TSGetPrevTime(ts, &before));
    r.taken = last_taken = time - before;
    PetscInt rejections = 0, iterations = 0;
    VOILE_PETSC(TSGetStepRejections(ts, &rejections));
    r.cut_short = cuts;
    r.shortest = shortest;
    r.rejections = static_cast<int>(rejections) - spent_rejections;
    spent_rejections = static_cast<int>(rejections);
    r.newton.converged = true;
    if (!explicit_method) {
      r.state.acceleration = acceleration(ts);
      SNES snes = nullptr;
      VOILE_PETSC(TSGetSNES(ts, &snes));
      VOILE_PETSC(SNESGetIterationNumber(snes, &iterations));
      r.newton.residual = residual;
      r.newton.negative_pivots = linear.negative_pivots();
    }
    r.newton.iterations = static_cast<int>(iterations);
    r.newton.factorisations = linear.factorisations() - spent_factorisations;
    spent_factorisations = linear.factorisations();
    result.newton_iterations += r.newton.iterations;
    result.newton = r.newton;
  }
  dynamics.set_time(r.state.time);
  if (observer && observer(r)) {
    result.stopped = true;
    VOILE_PETSC(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  }
}

PetscErrorCode TimeIntegration::Impl::post_step(TS ts) {
  void* self = nullptr;
  PetscFunctionBeginUser;
  PetscCall(TSGetApplicationContext(ts, &self));
  auto& n = *static_cast<Impl*>(self);
  const PetscErrorCode code = petsc::guarded([&] {
    PetscInt step = 0;
    PetscReal time = 0.0;
    TSConvergedReason reason = TS_CONVERGED_ITERATING;
    VOILE_PETSC(TSGetConvergedReason(ts, &reason));
    if (reason < 0) return;  // PETSc calls this after a step that failed, too
    VOILE_PETSC(TSGetStepNumber(ts, &step));
    VOILE_PETSC(TSGetTime(ts, &time));
    n.report(step, time);
  });
  PetscFunctionReturn(code);
}

TimeIntegration::TimeIntegration(system::Dynamics& dynamics, TimeOptions options)
    : impl_(std::make_unique<Impl>(dynamics, options)) {}
TimeIntegration::~TimeIntegration() = default;
void TimeIntegration::on_step(Observer observer) {
  impl_->observer = std::move(observer);
}
void TimeIntegration::on_remark(Remark remark) {
  impl_->remark = std::move(remark);
}

void read_time_options(TimeOptions& options) {
  PetscReal end = options.end_time;
  VOILE_PETSC(PetscOptionsGetReal(nullptr, nullptr, "-ts_max_time", &end, nullptr));
  if (!(end > 0.0)) throw UserError(fmt::format("-ts_max_time {}: must be > 0 s", end));
  options.end_time = end;
}

double largest_frequency(system::Dynamics& dynamics, Vec u) {
  system::Model& model = dynamics.model();
  model.assemble_tangent(u, nullptr, energy::Tangent::exact, 0.0);
  petsc::VecHandle x = start_mode(model), y = model.dofs().create_vector();
  double estimate = 0.0;
  for (int k = 0; k < 100; ++k) {
    model.dofs().clear_fixed(x);
    double size = 0.0, next = 0.0;
    VOILE_PETSC(VecNorm(x, NORM_2, &size));
    VOILE_PETSC(VecScale(x, 1.0 / size));
    VOILE_PETSC(MatMult(model.tangent_matrix(), x, y));
    VOILE_PETSC(VecPointwiseDivide(x, y, model.mass()));
    model.dofs().clear_fixed(x);
    VOILE_PETSC(VecNorm(x, NORM_2, &next));
    if (k > 10 && std::abs(next - estimate) <= 1e-4 * next) return std::sqrt(1.02 * next);
    estimate = next;
  }
  return std::sqrt(1.02 * estimate);  // the last percent may be missing from below
}

}  // namespace voile::solve

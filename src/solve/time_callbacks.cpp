// What PETSc calls back during a step: function, Jacobian, line search, convergence, the size of the next step.
#include <fmt/format.h>
#include <petsc/private/tsimpl.h>

#include <utility>

#include "alpha_ts.hpp"
#include "base/interrupt.hpp"
#include "linear/inexact_pc.hpp"
#include "step_bound.hpp"
#include "system/contact.hpp"
#include "time_integration_impl.hpp"

namespace voile::solve {

namespace {

constexpr double sufficient_decrease = 1e-4, shortest_length = 1e-6;
/// Fraction of the first step below which what an obstacle pinches may pass through it.
constexpr double pinched_step = 0.1;
/// Relative size at which a change of the energy is lost in its round-off.
constexpr double energy_round_off = 1e-12;
/// Increment over the size of a cell that moves nothing: a sheet at rest has forces and energies of round-off only.
constexpr double no_increment = 1e-10;
/// After an indefinite tangent so many positive ones are taken before the exact one is tried again. A sheet in contact
/// is full of wrinkles about to form, and the positive tangent is as good there.
constexpr int positive_tangents = 4, positive_tangents_in_contact = 40;
/// Rate of the residual above which an iteration is slow, if it is that of the one before but for this factor.
constexpr double slow_rate = 0.2, steady_rate = 1.5;
/// Relative tolerance of linear systems at the first iterations of a step, and the factor of the forcing sequence.
constexpr double loosest_tolerance = 1e-3, forcing_factor = 0.9;
/// An increment this close to what ends a step has to be right.
constexpr double nearly_last = 1.5;

}  // namespace

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
    n.tangent = {u, s_v, s_a, false};
    if (!n.exact_tangent && n.stay_positive()) {
      (void)n.assemble(energy::Tangent::positive);
    } else if (!n.assemble(energy::Tangent::exact) || n.linear.negative_pivots() > 0) {
      n.note_indefinite();
      (void)n.assemble(energy::Tangent::positive);
    }
    n.exact_tangent = false;
  });
}

/// Near a solution the exact tangent is positive more often than on the way, and there the positive one would converge
/// linearly only.
bool TimeIntegration::Impl::stay_positive() {
  const bool left = positive_left > 0;
  if (left) --positive_left;
  if (!left || again.exact) return false;
  return !again.slow || --again.left >= 0;
}

void TimeIntegration::Impl::note_indefinite() {
  positive_left = model.contact() ? positive_tangents_in_contact : positive_tangents;
  again = {again.slow, false, again.patience, 2 * again.patience, again.rate};
}

/// 0: the last iteration says nothing.
void TimeIntegration::Impl::note_rate(double rate) {
  const double last = std::exchange(again.rate, rate);
  // Falls of a drape seek no accuracy: their factors tell what is indefinite, and the search after them depends on where they end.
  again.slow = inexact && rate > slow_rate && rate < steady_rate * last && last < steady_rate * rate;
  again.exact = again.exact || (rate > 0.0 && !tangent.positive && positive_left > 0);
}

bool TimeIntegration::Impl::assemble(energy::Tangent kind) {
  tangent.positive = kind == energy::Tangent::positive;
  dynamics.assemble_tangent(tangent.u, kind, tangent.s_v, tangent.s_a);
  if (PC pc = linear.inexact()) linear::expect_indefinite(pc, !tangent.positive && !exact_tangent);
  linear.tangent_changed();
  return linear.factorise();
}

/// Negative curvature was met while the system was solved.
PetscErrorCode TimeIntegration::Impl::make_positive(void* self, PetscBool* changed) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    *changed = n.tangent.positive ? PETSC_FALSE : PETSC_TRUE;
    if (n.tangent.positive) return;
    n.note_indefinite();
    n.tangent.positive = true;
    n.dynamics.assemble_tangent(n.tangent.u, energy::Tangent::positive, n.tangent.s_v, n.tangent.s_a);
    n.linear.tangent_changed();
  });
}

void TimeIntegration::Impl::set_start(system::StepStart& start, Vec x, Vec v, double time, double size) {
  if (!start.u) start = {model.dofs().create_vector(), model.dofs().create_vector()};
  VOILE_PETSC(VecCopy(x, start.u));
  VOILE_PETSC(VecCopy(v, start.v));
  start.time = time;
  start.size = size;
}

PetscErrorCode TimeIntegration::Impl::start_step(void* self, Vec x, Vec v, PetscReal step) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    double t = 0.0;
    VOILE_PETSC(TSGetTime(n.ts, &t));
    n.dynamics.set_time(t);
    n.dynamics.start_step(x, v, step);
    VOILE_PETSC(VecCopy(x, n.start));
    if (n.remembers_start()) n.set_start(n.under_way, x, v, t, step);
    n.test.see(x);
    n.model.potential().count_from(x);  // so that a restart chooses its first guess by the same figures
    if (!n.model.contact()) n.positive_left = 0;
    n.again = {};
    n.cuts = 0;
    n.shortest = 1.0;
    if (PC pc = n.linear.inexact()) linear::set_inexact_tolerance(pc, 0.0);
  });
}

PetscErrorCode TimeIntegration::Impl::exactly(void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    n.exact_tangent = !n.model.contact();  // whose start would be factored instead
    if (PC pc = n.linear.inexact()) linear::set_inexact_tolerance(pc, 0.0);
  });
}

PetscErrorCode TimeIntegration::Impl::enforce(void* self, PetscReal t, Vec stage) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    n.dynamics.set_time(t);
    n.model.conditions().enforce(stage);
    if (std::exchange(n.held_at, t) == t) return;  // the same step again
    n.dynamics.prescribe_rates({t, n.options.step, n.options.end_time}, false, n.held_v, n.held_a);
  });
}

PetscErrorCode TimeIntegration::Impl::prescribe(void* self, Vec v, Vec a) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { n.take_rates(v, a); });
}

void TimeIntegration::Impl::take_rates(Vec v, Vec a) {
  const petsc::ReadArray velocities(held_v), accelerations(held_a);
  for (const auto& [to, from] : {std::pair(v, &velocities), std::pair(a, &accelerations)}) {
    if (!to) continue;
    const petsc::WriteArray out(to);
    for (const PetscInt i : model.conditions().led()) out[i] = (*from)[i];
  }
}

PetscErrorCode TimeIntegration::Impl::accepted(void* self, Vec x0, Vec x1, Vec v1) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    const AlphaStage s = alpha_stage(n.ts, x1);
    double t = 0.0, h = 0.0;
    VOILE_PETSC(TSGetTime(n.ts, &t));
    VOILE_PETSC(TSGetTimeStep(n.ts, &h));
    n.dynamics.set_time(s.time);
    n.account->take_forces(x0, x1, s.x, s.v, s.a);
    n.account->end_step(x1, v1, t, t + h);
  });
}

PetscErrorCode TimeIntegration::Impl::accelerate(void* self, PetscReal t, Vec x, Vec v, Vec a) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] {
    double h = 0.0;
    VOILE_PETSC(TSGetTimeStep(n.ts, &h));
    if (n.coming.u) {
      std::swap(n.under_way, n.coming);
      n.dynamics.set_time(n.under_way.time);
      n.dynamics.start_step(n.under_way.u, n.under_way.v, n.under_way.size);
    }
    n.dynamics.set_time(t);
    VOILE_PETSC(VecZeroEntries(a));
    n.dynamics.residual(x, v, a, n.trial);
    n.model.dofs().clear_fixed(n.trial);
    VOILE_PETSC(VecPointwiseDivide(a, n.trial, n.model.potential().constant().mass()));
    VOILE_PETSC(VecScale(a, -1.0));
    if (n.account) n.account->take_forces(n.start, x, x, v, a);
    VOILE_PETSC(VecCopy(x, n.start));
    // Drag and viscosity of the next half step, from when that begins: what is recorded here has those of this one.
    if (n.remembers_start()) {
      n.set_start(n.coming, x, v, t, h);
      n.take_rates(n.coming.v, nullptr);  // a restart knows the velocities of what is held at the end of the step
    } else {
      n.dynamics.start_step(x, v, h);
    }
  });
}

bool TimeIntegration::Impl::clear_predictor(double t0, Vec x0, double t1, Vec x1) {
  system::Contact& contact = *model.contact();
  system::Contact::Clearance way = contact.clear_predictor(x0, t0, x1, t1);
  if (!way.clear) {  // a guess that flies on may be worse than none
    dynamics.set_time(t1);
    VOILE_PETSC(VecCopy(x0, x1));
    model.conditions().enforce(x1);
    // Only what is still blocked in small steps is pinched.
    const bool may_pass = t1 - t0 <= std::max(pinched_step * options.step, 2.0 * options.min_step);
    const long before = system::passing_count(contact.memory());
    way = contact.clear_predictor(x0, t0, x1, t1, may_pass);
    if (way.clear && system::passing_count(contact.memory()) > before && before == 0 && remark)
      remark(fmt::format("t = {:.6g} s: {} vertices pass through an obstacle; {} was pinched", t0,
                         system::passing_count(contact.memory()), way.obstruction));
  }
  if (!way.clear) obstruction = way.obstruction;
  dynamics.set_time(t1);
  return way.clear;
}

PetscErrorCode TimeIntegration::Impl::clear(void* self, PetscReal t0, Vec x0, PetscReal t1, Vec x1,
                                            PetscBool* possible) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { *possible = n.clear_predictor(t0, x0, t1, x1) ? PETSC_TRUE : PETSC_FALSE; });
}

PetscErrorCode TimeIntegration::Impl::energy(void* self, Vec x1, PetscReal* value) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { *value = n.objective(x1); });
}

double TimeIntegration::Impl::objective(Vec x) {
  const AlphaStage s = alpha_stage(ts, x);
  return dynamics.energy(s.x, s.v, s.a, s.s_v, s.s_a);
}

/// Backtracking on the incremental potential; full steps where there is none (follower loads, inertia of rigid bodies).
void TimeIntegration::Impl::search(SNESLineSearch ls) {
  SNES snes = nullptr;
  Vec x = nullptr, f = nullptr, y = nullptr;
  VOILE_PETSC(SNESLineSearchGetSNES(ls, &snes));
  VOILE_PETSC(SNESLineSearchGetVecs(ls, &x, &f, &y, nullptr, nullptr));
  double slope = 0.0, norm = 0.0;
  VOILE_PETSC(VecDot(f, y, &slope));
  VOILE_PETSC(VecNorm(f, NORM_2, &norm));
  work = slope;
  length = allowed_fraction(model, x, y, trial);
  cut = length < 1.0;
  cuts += cut ? 1 : 0;
  if (model.conditions().symmetric() && model.dofs().motions().empty()) {
    model.potential().count_from(alpha_stage(ts, x).x);
    const double before = objective(x);
    const bool moves = root_mean_square(y) > no_increment * std::sqrt(model.discretisation().mean_area());
    for (;; length *= 0.5) {
      VOILE_PETSC(VecWAXPY(trial, -length, y, x));
      const double after = objective(trial);
      if (std::isfinite(after) && !moves) break;
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
  rms = length * root_mean_square(y);
  VOILE_PETSC(SNESComputeFunction(snes, x, f));
  VOILE_PETSC(SNESLineSearchSetLambda(ls, length));
  VOILE_PETSC(SNESLineSearchComputeNorms(ls));
}

PetscErrorCode TimeIntegration::Impl::line_search(SNESLineSearch ls, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return petsc::guarded([&] { n.search(ls); });
}

// ---- how exactly systems are solved ---------------------------------------------------------------------------------

void TimeIntegration::Impl::prepare_inexact(const system::SolverMemory& memory) {
  positive_left = memory.positive_tangents;
  PC pc = linear.inexact();
  if (!pc) return;
  linear::set_inexact_memory(pc, {memory.factors_left, memory.wait});
  if (!model.contact()) linear::set_inexact_double(pc);
  linear::InexactCallbacks callbacks;
  callbacks.context = this;
  callbacks.make_positive = make_positive;
  callbacks.is_last = [](void* self, Vec x, PetscBool* last) {
    auto& n = *static_cast<Impl*>(self);
    return petsc::guarded([&] { *last = n.is_last(x) ? PETSC_TRUE : PETSC_FALSE; });
  };
  callbacks.say = [](void* self, const std::string& text) {
    auto& n = *static_cast<Impl*>(self);
    return petsc::guarded([&] {
      double t = 0.0;
      VOILE_PETSC(TSGetTime(n.ts, &t));
      if (n.remark) n.remark(fmt::format("t = {:.6g} s: {}", t, text));
    });
  };
  linear::set_inexact_callbacks(pc, callbacks);
}

system::SolverMemory TimeIntegration::Impl::solver_memory() const {
  PC pc = linear.inexact();
  const linear::InexactMemory m = pc ? linear::inexact_memory(pc) : linear::InexactMemory{};
  return {positive_left, m.factors_left, m.wait};
}

/// Eisenstat & Walker, SIAM J. Sci. Comput. 17 (1996) 16-32, choice 2.
void TimeIntegration::Impl::set_tolerance(PetscInt it, double norm, double before) {
  PC pc = linear.inexact();
  if (!pc) return;
  const double ratio = it > 0 && before > 0.0 && !cut ? norm / before : 1.0;
  linear::set_inexact_tolerance(pc, std::min(loosest_tolerance, forcing_factor * ratio * ratio));
}

bool TimeIntegration::Impl::is_last(Vec y) {
  double h = 0.0, norm = 0.0, step = 0.0;
  Vec x = nullptr;
  SNES snes = nullptr;
  VOILE_PETSC(TSGetSNES(ts, &snes));
  VOILE_PETSC(SNESGetSolution(snes, &x));
  VOILE_PETSC(TSGetTimeStep(ts, &h));
  if (root_mean_square(y) <= nearly_last * last_increment(h)) return true;
  if (!x) return true;
  VOILE_PETSC(VecNorm(y, NORM_2, &norm));
  VOILE_PETSC(VecWAXPY(trial, -1.0, start, x));
  VOILE_PETSC(VecNorm(trial, NORM_2, &step));
  return test.is_small(norm, step);
}

// ---- step size -----------------------------------------------------------------------------------------------------

/// The size of a step from time t, or what of it turns clamps and moves obstacles by little.
double TimeIntegration::Impl::by_motions(double t, double h) const {
  double fraction = fraction_by_turn(model, t, t + h, false);
  if (model.contact()) fraction = std::min(fraction, fraction_by_obstacles(model, t, t + h));
  return std::max(std::min(h, options.min_step), h * fraction);
}

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
  wanted = only_cut ? std::max(next, wanted) : next;
  double t = 0.0;
  VOILE_PETSC(TSGetTime(ts, &t));
  return by_motions(t + h, wanted);
}

PetscErrorCode TimeIntegration::Impl::choose(TSAdapt adapt, TS, PetscReal h, PetscInt* scheme, PetscReal* next,
                                             PetscBool* accept, PetscReal* error, PetscReal* absolute,
                                             PetscReal* relative) {
  auto& n = *static_cast<Impl*>(adapt->data);
  *scheme = 0;
  *absolute = *relative = -1.0;
  return petsc::guarded([&] { *next = n.next_step(h, accept, error); });
}

}  // namespace voile::solve

#include "alpha_ts.hpp"

#include "alpha_ts_impl.hpp"
#include "base/petsc.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

namespace {

/// A step that cannot even start is repeated with this fraction of its size.
constexpr double blocked_step_factor = 0.4;

/// V1, A1 and the stage from a trial X1, which may be th.x1 (the SNES's solution, never written here).
PetscErrorCode set_stage(TS ts, Vec x1) {
  AlphaData& th = alpha_data(ts);
  const double h = ts->time_step;
  PetscFunctionBeginUser;
  // A1 = (X1 - X0 - h V0)/(beta h^2) + (1 - 1/(2 beta)) A0
  PetscCall(VecWAXPY(th.a1, -1.0, th.x0, x1));
  PetscCall(VecAXPBYPCZ(th.a1, -1.0 / (h * th.beta), 1.0 - 0.5 / th.beta, 1.0 / (h * h * th.beta), th.v0, th.a0));
  PetscCall(VecWAXPY(th.v1, h * (1.0 - th.gamma), th.a0, th.v0));
  PetscCall(VecAXPY(th.v1, h * th.gamma, th.a1));
  if (th.callbacks.prescribe) PetscCall(th.callbacks.prescribe(th.callbacks.context, th.v1, th.a1));
  if (x1 != th.xa) PetscCall(VecCopy(x1, th.xa));
  PetscCall(VecAXPBYPCZ(th.aa, 1.0 - th.a_m, th.a_m, 0.0, th.a0, th.a1));
  PetscFunctionReturn(0);
}

/// X1 of one kind of predictor, prescribed components set, the way there free; `possible` is false if there is none.
PetscErrorCode guess(TS ts, AlphaPredictor predictor, PetscBool* possible) {
  AlphaData& th = alpha_data(ts);
  const double h = ts->time_step;
  PetscFunctionBeginUser;
  *possible = PETSC_TRUE;
  PetscCall(VecCopy(th.x0, th.x1));
  if (predictor != AlphaPredictor::position) PetscCall(VecAXPY(th.x1, h, th.v0));
  if (predictor == AlphaPredictor::acceleration) PetscCall(VecAXPY(th.x1, 0.5 * h * h, th.a0));
  if (!th.callbacks.enforce) PetscFunctionReturn(0);
  PetscCall(th.callbacks.enforce(th.callbacks.context, th.stage_time, th.x1));
  if (th.callbacks.clear)
    PetscCall(th.callbacks.clear(th.callbacks.context, ts->ptime, th.x0, th.stage_time, th.x1, possible));
  PetscFunctionReturn(0);
}

/// First guess of a step; `possible` is false if nobody finds a place to start from, so that the step must be smaller.
/// With contact the motion gone on with its acceleration may end in a wall: the velocity alone counts if that has less
/// energy. (The state before would often have still less, but what rests there seems to stick.) An acceleration that flies
/// over many cells, as that of a seam which has just been welded while folded sharply, is no guess at all.
PetscErrorCode predict(TS ts, PetscBool* possible) {
  AlphaData& th = alpha_data(ts);
  PetscBool other = PETSC_FALSE;
  PetscReal first = 0.0, second = 0.0, most = 0.0;
  AlphaPredictor predictor = th.predictor;
  PetscFunctionBeginUser;
  if (th.callbacks.energy && predictor == AlphaPredictor::acceleration) {
    PetscCall(VecNorm(th.a0, NORM_INFINITY, &most));
    if (0.5 * ts->time_step * ts->time_step * most > th.callbacks.longest_flight) predictor = AlphaPredictor::velocity;
  }
  PetscCall(guess(ts, predictor, possible));
  if (!th.callbacks.energy || predictor != AlphaPredictor::acceleration) PetscFunctionReturn(0);
  if (*possible) PetscCall(th.callbacks.energy(th.callbacks.context, th.x1, &first));
  PetscCall(VecCopy(th.x1, th.best));
  PetscCall(guess(ts, AlphaPredictor::velocity, &other));
  if (other) PetscCall(th.callbacks.energy(th.callbacks.context, th.x1, &second));
  if (!other || (*possible && !(second < first))) PetscCall(VecCopy(th.best, th.x1));
  if (other) *possible = PETSC_TRUE;
  PetscFunctionReturn(0);
}

/// After a rejection, with the next size set: ends the run after too many, or when the step has become too small.
PetscErrorCode count_rejection(TS ts, PetscInt* rejections) {
  PetscReal least = 0.0;
  PetscFunctionBeginUser;
  PetscCall(TSAdaptGetStepLimits(ts->adapt, &least, nullptr));
  ts->reject++;
  if (ts->reason) PetscFunctionReturn(0);
  const PetscBool many = (++*rejections > ts->max_reject && ts->max_reject >= 0) ? PETSC_TRUE : PETSC_FALSE;
  if (many || ts->time_step < least * (1.0 - 1e-12)) ts->reason = TS_DIVERGED_STEP_REJECTED;
  PetscFunctionReturn(0);
}

PetscErrorCode step(TS ts) {
  AlphaData& th = alpha_data(ts);
  PetscInt rejections = 0, its = 0, lits = 0;
  PetscBool stage_good = PETSC_FALSE, accepted = PETSC_FALSE;
  PetscReal next = ts->time_step;
  PetscFunctionBeginUser;
  PetscCall(VecCopy(ts->vec_sol, th.x0));
  PetscCall(VecCopy(ts->vec_dot, th.v0));
  if (!ts->steprollback) {
    if (ts->steprestart && !th.has_acceleration) PetscCall(begin_alpha(ts));
    PetscCall(VecCopy(th.a1, th.a0));
  }
  while (!ts->reason) {
    PetscCall(set_alpha_shifts(ts));
    if (th.callbacks.start_step) PetscCall(th.callbacks.start_step(th.callbacks.context, th.x0, th.v0, ts->time_step));
    PetscBool possible = PETSC_TRUE;
    PetscCall(predict(ts, &possible));
    if (!possible) {
      ts->time_step *= blocked_step_factor;
      PetscCall(count_rejection(ts, &rejections));
      continue;
    }
    PetscCall(TSPreStage(ts, th.stage_time));
    PetscCall(SNESSolve(ts->snes, nullptr, th.x1));
    if (th.callbacks.solved) PetscCall(th.callbacks.solved(th.callbacks.context, th.x1));
    PetscCall(SNESGetIterationNumber(ts->snes, &its));
    PetscCall(SNESGetLinearSolveIterations(ts->snes, &lits));
    ts->snes_its += its;
    ts->ksp_its += lits;
    PetscCall(set_stage(ts, th.x1));
    PetscCall(TSPostStage(ts, th.stage_time, 0, &th.xa));
    PetscCall(TSAdaptCheckStage(ts->adapt, ts, th.stage_time, th.xa, &stage_good));
    accepted = stage_good;
    if (accepted) {
      PetscCall(VecCopy(th.x1, ts->vec_sol));
      PetscCall(VecCopy(th.v1, ts->vec_dot));
      PetscCall(TSAdaptChoose(ts->adapt, ts, ts->time_step, nullptr, &next, &accepted));
      if (!accepted) {
        PetscCall(VecCopy(th.x0, ts->vec_sol));
        PetscCall(VecCopy(th.v0, ts->vec_dot));
        ts->time_step = next;
      }
    }
    if (accepted) break;
    PetscCall(count_rejection(ts, &rejections));
  }
  if (accepted) {
    if (th.callbacks.accepted) PetscCall(th.callbacks.accepted(th.callbacks.context, th.x0, th.x1, th.v1));
    ts->ptime += ts->time_step;
    ts->time_step = next;
    if (th.backward) PetscCall(end_backward_step(ts));
    th.has_acceleration = true;
  } else {
    PetscCall(VecCopy(th.a0, th.a1));
  }
  PetscFunctionReturn(0);
}

PetscErrorCode local_error(TS ts, NormType type, PetscInt* order, PetscReal* error) {
  AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  const double h = ts->time_step,
               c = th.backward ? 0.5 * h * h : (1.0 / 12.0 + 0.25 * (th.a_m - 1.0) * (th.a_m - 1.0)) * h * h;
  PetscReal absolute = 0, relative = 0;
  PetscCall(VecCopy(th.x1, th.aa));
  PetscCall(VecAXPY(th.aa, c, th.a1));
  PetscCall(VecAXPY(th.aa, -c, th.a0));
  PetscCall(TSErrorWeightedNorm(ts, th.x1, th.aa, type, error, &absolute, &relative));
  if (order) *order = 3;
  PetscFunctionReturn(0);
}

PetscErrorCode roll_back(TS ts) {
  AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  PetscCall(VecCopy(th.x0, ts->vec_sol));
  PetscCall(VecCopy(th.v0, ts->vec_dot));
  PetscCall(VecCopy(th.a0, th.a1));
  PetscFunctionReturn(0);
}

/// Cubic Hermite interpolation of the last step.
PetscErrorCode interpolate(TS ts, PetscReal t, Vec x) {
  AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  const double h = ts->ptime - ts->ptime_prev, s = (t - ts->ptime_prev) / h;
  PetscCall(VecCopy(th.x0, x));
  PetscCall(
      VecAXPBYPCZ(x, s * s * (3 - 2 * s), h * s * (1 - s) * (1 - s), 1.0 - s * s * (3 - 2 * s), ts->vec_sol, th.v0));
  PetscCall(VecAXPY(x, -h * s * s * (1 - s), ts->vec_dot));
  PetscFunctionReturn(0);
}

PetscErrorCode snes_function(SNES, Vec x, Vec f, TS ts) {
  AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  if (th.starting) {
    PetscCall(TSComputeI2Function(ts, ts->ptime, x, th.v0, th.a0, f));
    PetscFunctionReturn(0);
  }
  PetscCall(set_stage(ts, x));
  PetscCall(TSComputeI2Function(ts, th.stage_time, th.xa, th.v1, th.aa, f));
  PetscFunctionReturn(0);
}

PetscErrorCode snes_jacobian(SNES, Vec, Mat j, Mat p, TS ts) {
  AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  if (th.starting)
    PetscCall(TSComputeI2Jacobian(ts, ts->ptime, th.x1, th.v0, th.a0, th.start_s_v, 1.0 / th.start_scale, j, p));
  else
    PetscCall(TSComputeI2Jacobian(ts, th.stage_time, th.xa, th.v1, th.aa, th.s_v, th.s_a, j, p));
  PetscFunctionReturn(0);
}

PetscErrorCode set_up(TS ts) {
  AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  if (!ts->vec_dot)
    SETERRQ(PetscObjectComm(reinterpret_cast<PetscObject>(ts)), PETSC_ERR_ARG_WRONGSTATE,
            "TS2SetSolution must be called first");
  th.set_parameters();
  for (Vec* v : {&th.x0, &th.xa, &th.x1, &th.v0, &th.v1, &th.a0, &th.aa, &th.a1, &th.best})
    if (!*v) PetscCall(VecDuplicate(ts->vec_sol, v));
  PetscCall(TSGetAdapt(ts, &ts->adapt));
  PetscCall(TSAdaptCandidatesClear(ts->adapt));
  PetscCall(TSGetSNES(ts, &ts->snes));
  PetscFunctionReturn(0);
}

PetscErrorCode reset(TS ts) {
  AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  for (Vec* v : {&th.x0, &th.xa, &th.x1, &th.v0, &th.v1, &th.a0, &th.aa, &th.a1, &th.best}) PetscCall(VecDestroy(v));
  th.has_acceleration = false;
  PetscFunctionReturn(0);
}

PetscErrorCode destroy(TS ts) {
  PetscFunctionBeginUser;
  PetscCall(reset(ts));
  delete static_cast<AlphaData*>(ts->data);
  ts->data = nullptr;
  PetscFunctionReturn(0);
}

PetscErrorCode ask_options(TS ts, PetscOptionItems* PetscOptionsObject) {
  AlphaData& th = alpha_data(ts);
  static constexpr const char* predictors[] = {"position", "velocity", "acceleration"};
  PetscReal radius = th.radius;
  auto predictor = static_cast<PetscInt>(th.predictor);
  PetscFunctionBeginUser;
  PetscOptionsHeadBegin(PetscOptionsObject, "Generalised-alpha for second-order equations");
  PetscCall(
      PetscOptionsReal("-ts_voile_radius", "Spectral radius at infinite frequency", nullptr, radius, &radius, nullptr));
  PetscCall(PetscOptionsEList("-ts_voile_predictor", "First guess of a step", nullptr, predictors, 3,
                              predictors[predictor], &predictor, nullptr));
  PetscOptionsHeadEnd();
  if (radius < 0.0 || radius > 1.0)
    SETERRQ(PetscObjectComm(reinterpret_cast<PetscObject>(ts)), PETSC_ERR_ARG_OUTOFRANGE,
            "-ts_voile_radius must be between 0 and 1");
  th.radius = radius;
  th.predictor = static_cast<AlphaPredictor>(predictor);
  PetscFunctionReturn(0);
}

PetscErrorCode view(TS ts, PetscViewer viewer) {
  const AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  PetscCall(PetscViewerASCIIPrintf(viewer, "  radius=%g, alpha_m=%g, gamma=%g, beta=%g\n", th.radius, th.a_m, th.gamma,
                                   th.beta));
  PetscFunctionReturn(0);
}

PetscErrorCode create(TS ts) {
  PetscFunctionBeginUser;
  ts->data = new AlphaData;
  ts->ops->setup = set_up;
  ts->ops->reset = reset;
  ts->ops->destroy = destroy;
  ts->ops->view = view;
  ts->ops->setfromoptions = ask_options;
  ts->ops->step = step;
  ts->ops->evaluatewlte = local_error;
  ts->ops->rollback = roll_back;
  ts->ops->interpolate = interpolate;
  ts->ops->snesfunction = snes_function;
  ts->ops->snesjacobian = snes_jacobian;
  ts->default_adapt_type = TSADAPTNONE;
  ts->usessnes = PETSC_TRUE;
  PetscFunctionReturn(0);
}

}  // namespace

void register_alpha_ts() {
  static bool done = false;
  if (!done) VOILE_PETSC(TSRegister(alpha_ts_type, create));
  done = true;
}

void set_alpha_callbacks(TS ts, const AlphaCallbacks& callbacks) {
  alpha_data(ts).callbacks = callbacks;
}

void set_alpha_radius(TS ts, double radius) {
  alpha_data(ts).radius = radius;
}

double alpha_radius(TS ts) {
  return alpha_data(ts).radius;
}

AlphaStage alpha_stage(TS ts, Vec x1) {
  VOILE_PETSC(set_stage(ts, x1));
  const AlphaData& th = alpha_data(ts);
  return {th.xa, th.v1, th.aa, th.stage_time, th.s_v, th.s_a};
}

void set_acceleration(TS ts, Vec a) {
  VOILE_PETSC(TSSetUp(ts));
  VOILE_PETSC(VecCopy(a, alpha_data(ts).a1));
  alpha_data(ts).has_acceleration = true;
}

void abandon_step(TS ts) {
  if (alpha_data(ts).has_acceleration) VOILE_PETSC(roll_back(ts));
}

Vec acceleration(TS ts) {
  return alpha_data(ts).has_acceleration ? alpha_data(ts).a1 : nullptr;
}

}  // namespace voile::solve

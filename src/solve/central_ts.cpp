#include "central_ts.hpp"

#include <petsc/private/tsimpl.h>

#include "base/petsc.hpp"

namespace voile::solve {

namespace {

struct Central {
  CentralCallbacks callbacks;
  Vec a = nullptr, guess = nullptr;
  bool has_acceleration = false;
};

Central& data(TS ts) {
  return *static_cast<Central*>(ts->data);
}

PetscErrorCode step(TS ts) {
  Central& c = data(ts);
  const double h = ts->time_step;
  PetscBool accepted = PETSC_TRUE;
  PetscReal next = h;
  PetscFunctionBeginUser;
  if (!c.has_acceleration)
    PetscCall(c.callbacks.accelerate(c.callbacks.context, ts->ptime, ts->vec_sol, ts->vec_dot, c.a));
  PetscCall(VecAXPY(ts->vec_dot, 0.5 * h, c.a));
  PetscCall(VecAXPY(ts->vec_sol, h, ts->vec_dot));
  PetscCall(VecCopy(ts->vec_sol, c.guess));
  PetscCall(c.callbacks.enforce(c.callbacks.context, ts->ptime + h, ts->vec_sol));
  // What is held moves at the velocity that takes it where it is put.
  PetscCall(VecAXPY(c.guess, -1.0, ts->vec_sol));
  PetscCall(VecAXPY(ts->vec_dot, -1.0 / h, c.guess));
  PetscCall(c.callbacks.accelerate(c.callbacks.context, ts->ptime + h, ts->vec_sol, ts->vec_dot, c.a));
  PetscCall(VecAXPY(ts->vec_dot, 0.5 * h, c.a));
  PetscCall(c.callbacks.prescribe(c.callbacks.context, ts->vec_dot, nullptr));
  c.has_acceleration = true;
  PetscReal size = 0.0;
  PetscCall(VecNorm(ts->vec_sol, NORM_2, &size));
  if (!std::isfinite(size)) {
    ts->reason = TS_DIVERGED_STEP_REJECTED;
    PetscFunctionReturn(0);
  }
  PetscCall(TSAdaptChoose(ts->adapt, ts, h, nullptr, &next, &accepted));
  ts->ptime += h;
  ts->time_step = next;
  PetscFunctionReturn(0);
}

PetscErrorCode set_up(TS ts) {
  Central& c = data(ts);
  PetscFunctionBeginUser;
  if (!ts->vec_dot)
    SETERRQ(PetscObjectComm(reinterpret_cast<PetscObject>(ts)), PETSC_ERR_ARG_WRONGSTATE,
            "TS2SetSolution must be called first");
  for (Vec* v : {&c.a, &c.guess})
    if (!*v) PetscCall(VecDuplicate(ts->vec_sol, v));
  PetscCall(TSGetAdapt(ts, &ts->adapt));
  PetscCall(TSAdaptCandidatesClear(ts->adapt));
  PetscFunctionReturn(0);
}

PetscErrorCode reset(TS ts) {
  PetscFunctionBeginUser;
  PetscCall(VecDestroy(&data(ts).a));
  PetscCall(VecDestroy(&data(ts).guess));
  data(ts).has_acceleration = false;
  PetscFunctionReturn(0);
}

PetscErrorCode destroy(TS ts) {
  PetscFunctionBeginUser;
  PetscCall(reset(ts));
  delete static_cast<Central*>(ts->data);
  ts->data = nullptr;
  PetscFunctionReturn(0);
}

PetscErrorCode create(TS ts) {
  PetscFunctionBeginUser;
  ts->data = new Central;
  ts->ops->setup = set_up;
  ts->ops->reset = reset;
  ts->ops->destroy = destroy;
  ts->ops->step = step;
  ts->default_adapt_type = TSADAPTNONE;
  ts->usessnes = PETSC_FALSE;
  PetscFunctionReturn(0);
}

}  // namespace

void register_central_ts() {
  static bool done = false;
  if (!done) VOILE_PETSC(TSRegister(central_ts_type, create));
  done = true;
}

void set_central_callbacks(TS ts, const CentralCallbacks& callbacks) {
  data(ts).callbacks = callbacks;
}

void set_central_acceleration(TS ts, Vec a) {
  VOILE_PETSC(TSSetUp(ts));
  VOILE_PETSC(VecCopy(a, data(ts).a));
  data(ts).has_acceleration = true;
}

Vec central_acceleration(TS ts) {
  return data(ts).a;
}

}  // namespace voile::solve

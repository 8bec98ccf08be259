// How a motion begins: the first acceleration, or a first step of backward Euler.
#include "alpha_ts_impl.hpp"
#include "base/petsc.hpp"

namespace voile::solve {

PetscErrorCode set_alpha_shifts(TS ts) {
  AlphaData& th = alpha_data(ts);
  const double h = ts->time_step;
  PetscFunctionBeginUser;
  th.stage_time = ts->ptime + h;
  th.s_v = th.gamma / (h * th.beta);
  th.s_a = th.a_m / (h * h * th.beta);
  PetscFunctionReturn(0);
}

namespace {

/// Solves F(t0, X0 + eps A, V0, A) = 0 for A: with eps small against the square of every period that matters, the
/// Jacobian eps dF/dX + dF/dA needs no mass matrix of its own and holds fixed rows. If `stiff`, eps and V1 are those of the
/// step: friction without slip holds nothing at X0, and V1 would take what it balances as accelerations of 1e4 m/s^2.
PetscErrorCode start_acceleration(TS ts, bool stiff) {
  AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  th.start_scale = (stiff ? th.beta : 1e-8) * ts->time_step * ts->time_step;
  th.start_s_v = stiff ? th.s_v : 0.0;
  th.starting = true;
  PetscCall(VecZeroEntries(th.a0));
  PetscCall(VecCopy(th.x0, th.x1));
  Mat j = nullptr, p = nullptr;
  KSP ksp = nullptr;
  if (th.callbacks.exactly) PetscCall(th.callbacks.exactly(th.callbacks.context));
  // X1 = X0 + eps A: the function of X1 is linear in A.
  PetscCall(SNESGetJacobian(ts->snes, &j, &p, nullptr, nullptr));
  PetscCall(SNESComputeFunction(ts->snes, th.x1, th.aa));
  PetscCall(SNESComputeJacobian(ts->snes, th.x1, j, p));
  PetscCall(SNESGetKSP(ts->snes, &ksp));
  PetscCall(KSPSetOperators(ksp, j, p));
  PetscCall(KSPSolve(ksp, th.aa, th.a0));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  ts->ksp_its += 1;
  th.starting = false;
  if (reason < 0) {  // forces, masses or their ratio are no numbers: the run ends as one that does not converge
    ts->reason = TSFORWARD_DIVERGED_LINEAR_SOLVE;
    PetscCall(VecZeroEntries(th.a0));
  }
  PetscCall(VecScale(th.a0, -1.0 / th.start_scale));
  PetscCall(VecCopy(th.a0, th.a1));
  th.has_acceleration = true;
  PetscFunctionReturn(0);
}

}  // namespace

/// A1 of a run that begins, or A0 = 0 where its first step is one of backward Euler: velocities that are damped within a fraction of
/// it leave no displacement, and a start that is only smooth loses no order.
PetscErrorCode begin_alpha(TS ts) {
  AlphaData& th = alpha_data(ts);
  PetscReal speed = 0.0;
  PetscFunctionBeginUser;
  PetscCall(VecNorm(th.v0, NORM_INFINITY, &speed));
  th.backward = th.callbacks.damped && speed > 0.0;
  th.set_parameters();
  PetscCall(set_alpha_shifts(ts));
  if (th.backward) {
    PetscCall(VecZeroEntries(th.a1));
    PetscFunctionReturn(0);
  }
  if (th.callbacks.start_step) PetscCall(th.callbacks.start_step(th.callbacks.context, th.x0, th.v0, ts->time_step));
  PetscCall(start_acceleration(ts, th.callbacks.stiff_start));
  PetscFunctionReturn(0);
}

/// A1 after a step of backward Euler: its (V1 - V0)/h still has what was damped within the step.
PetscErrorCode end_backward_step(TS ts) {
  AlphaData& th = alpha_data(ts);
  PetscFunctionBeginUser;
  th.backward = false;
  th.set_parameters();
  PetscCall(set_alpha_shifts(ts));
  PetscCall(VecCopy(ts->vec_sol, th.x0));
  PetscCall(VecCopy(ts->vec_dot, th.v0));
  PetscCall(start_acceleration(ts, true));
  PetscFunctionReturn(0);
}

}  // namespace voile::solve

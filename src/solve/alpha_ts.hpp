// Generalised-alpha time stepping as a TS type of PETSc: -ts_type voile_alpha.
//
// Symbols   X, V, A   position, velocity, acceleration at the start (0) and the end (1) of a step of size h
//           F(t, X, V, A) = 0  the equations (TSSetI2Function);  rho spectral radius at infinite frequency
//   X1 = X0 + h V0 + h^2 ((1/2 - beta) A0 + beta A1),   V1 = V0 + h ((1 - gamma) A0 + gamma A1)
//   F(t0 + h, X1, V1, A0 + a_m (A1 - A0)) = 0
//   a_m = 2/(1 + rho),   gamma = a_m - 1/2,   beta = a_m^2 / 4
// Source: W.L. Wood, M. Bossak, O.C. Zienkiewicz, Int. J. Numer. Meth. Engng 15 (1980) 1562-1566, with the parameters of J. Chung,
// G.M. Hulbert, J. Appl. Mech. 60 (1993) 371-375. Second order, unconditionally stable on linear problems. Start: A0 solves
// F(t0, X0, V0, A0) = 0, after every restart of the time stepper, unless it is given or the first step is one of backward
// Euler (`damped`). Error of a step: (1/12 + (a_m - 1)^2/4) h^2
// (A1 - A0), of third order, for TSAdapt. The unknown of the SNES is X1. Options: -ts_voile_radius,
// -ts_voile_predictor position|velocity|acceleration: what the first guess of X1 goes on with; with the callback
// `energy`, the acceleration only where that has less of it than the velocity alone, and flies no further than
// `longest_flight`. Theory: docs/theory/time-integration.md (3).
#pragma once

#include <petscts.h>

namespace voile::solve {

inline constexpr const char* alpha_ts_type = "voile_alpha";

/// What the type asks of its user besides TSSetI2Function and TSSetI2Jacobian.
struct AlphaCallbacks {
  void* context = nullptr;
  /// Before the first function of a step: state (X0, V0) and the size of the step.
  PetscErrorCode (*start_step)(void* context, Vec x, Vec v, PetscReal step) = nullptr;
  /// Puts prescribed components of a stage position right at time t.
  PetscErrorCode (*enforce)(void* context, PetscReal t, Vec stage) = nullptr;
  /// Puts prescribed components of V and A right at the time of the last enforce().
  PetscErrorCode (*prescribe)(void* context, Vec v, Vec a) = nullptr;
  /// Moves the first guess X1 at time t1 to where a search may start, coming from X0 at t0; false if there is no such
  /// place, and the step must be smaller.
  PetscErrorCode (*clear)(void* context, PetscReal t0, Vec x0, PetscReal t1, Vec x1, PetscBool* possible) = nullptr;
  /// Potential whose minimum over X1 is looked for; with it the better of two first guesses is taken.
  PetscErrorCode (*energy)(void* context, Vec x1, PetscReal* energy) = nullptr;
  /// With an energy: where the acceleration alone would carry a component further than this in the step [m], it is
  /// left out of the first guess.
  PetscReal longest_flight = PETSC_INFINITY;
  /// A step from X0 to (X1, V1) is accepted; time and step size are still those of its start, for alpha_stage().
  PetscErrorCode (*accepted)(void* context, Vec x0, Vec x1, Vec v1) = nullptr;
  /// The first acceleration is found with the stiffness and damping of a step, not with the mass alone.
  bool stiff_start = false;
  /// Velocities of the start may be damped within a fraction of a step: the first is one of backward Euler, unless all are zero.
  bool damped = false;
  /// The next linear system is to be solved as exactly as can be: no iteration follows that would mend it.
  PetscErrorCode (*exactly)(void* context) = nullptr;
  /// The SNES has stopped at X1: may overrule its reason (SNESSetConvergedReason).
  PetscErrorCode (*solved)(void* context, Vec x1) = nullptr;
};

/// What of a step tells about X1: stage (Xa, Va, Aa) with dVa/dXa = s_v and dAa/dXa = s_a.
struct AlphaStage {
  Vec x, v, a;
  PetscReal time, s_v, s_a;
};

/// Back to the start of a step that an exception ended.
void abandon_step(TS ts);

/// Makes the type known to PETSc; once per process is enough.
void register_alpha_ts();
/// Callbacks are copied.
void set_alpha_callbacks(TS ts, const AlphaCallbacks& callbacks);
/// Spectral radius in [0, 1].
void set_alpha_radius(TS ts, double radius);
/// Spectral radius in force, which the command line may have changed.
[[nodiscard]] double alpha_radius(TS ts);
/// The stage that belongs to a trial X1. The vectors belong to the TS.
[[nodiscard]] AlphaStage alpha_stage(TS ts, Vec x1);
/// Gives the acceleration at the current state, as a checkpoint does; copied.
void set_acceleration(TS ts, Vec a);
/// The acceleration at the current state, owned by the TS; null before the first step.
[[nodiscard]] Vec acceleration(TS ts);

}  // namespace voile::solve

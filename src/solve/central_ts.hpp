// Central differences as a TS type of PETSc: -ts_type voile_central.
//
//   V_h = V0 + h/2 A0,   X1 = X0 + h V_h,   A1 = acceleration(t1, X1, V_h),   V1 = V_h + h/2 A1
// the velocity-Verlet form of the central difference with lumped mass; damping forces use the velocity V_h of the
// middle of the step. Stable for h < 2/omega_max. Source: T. Belytschko, W.K. Liu, B. Moran, Nonlinear Finite Elements
// for Continua and Structures (2000), section 6.2.
#pragma once

#include <petscts.h>

namespace voile::solve {

inline constexpr const char* central_ts_type = "voile_central";

struct CentralCallbacks {
  void* context = nullptr;
  /// A from X, V at time t.
  PetscErrorCode (*accelerate)(void* context, PetscReal t, Vec x, Vec v, Vec a) = nullptr;
  /// Puts prescribed components of a position right at time t.
  PetscErrorCode (*enforce)(void* context, PetscReal t, Vec x) = nullptr;
  /// Puts prescribed components of V right at the time of the last enforce().
  PetscErrorCode (*prescribe)(void* context, Vec v, Vec a) = nullptr;
};

/// Makes the type known to PETSc; once per process is enough.
void register_central_ts();
void set_central_callbacks(TS ts, const CentralCallbacks& callbacks);
/// A0 of the next step, copied; without it, it is found from X0 and V0, where V_h of the step before is not known. Collective.
void set_central_acceleration(TS ts, Vec a);
/// A1 of the last step, owned by the TS.
[[nodiscard]] Vec central_acceleration(TS ts);

}  // namespace voile::solve

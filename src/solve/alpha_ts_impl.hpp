// The own data of generalised-alpha time stepping (alpha_ts.hpp), shared by its two source files.
#pragma once

#include <petsc/private/tsimpl.h>

#include "alpha_ts.hpp"

namespace voile::solve {

enum class AlphaPredictor { position, velocity, acceleration };

/// The type's own data (ts->data).
struct AlphaData {
  double radius = 0.5;
  AlphaPredictor predictor = AlphaPredictor::acceleration;
  double a_m = 0, gamma = 0, beta = 0;
  AlphaCallbacks callbacks;
  Vec x0{}, xa{}, x1{}, v0{}, v1{}, a0{}, aa{}, a1{}, best{};
  bool has_acceleration = false;              ///< a1 belongs to the current state
  bool starting = false;                      ///< the SNES is solving for the first acceleration
  bool backward = false;                      ///< the step is one of backward Euler: A0 = 0, all parameters 1
  double start_scale = 0.0, start_s_v = 0.0;  ///< over X1 - X0 then: A by 1/start_scale, V1 - V0 by start_s_v
  double stage_time = 0, s_v = 0, s_a = 0;

  void set_parameters() {
    if (backward) {
      a_m = gamma = beta = 1.0;
      return;
    }
    a_m = 2.0 / (1.0 + radius);
    gamma = a_m - 0.5;
    beta = 0.25 * a_m * a_m;
  }
};

inline AlphaData& alpha_data(TS ts) {
  return *static_cast<AlphaData*>(ts->data);
}

/// Stage time and shifts of a step of the current size.
PetscErrorCode set_alpha_shifts(TS ts);
/// A1 of a run that begins, or A0 = 0 where its first step is one of backward Euler. Collective.
PetscErrorCode begin_alpha(TS ts);
/// A1 after a step of backward Euler. Collective.
PetscErrorCode end_backward_step(TS ts);

}  // namespace voile::solve

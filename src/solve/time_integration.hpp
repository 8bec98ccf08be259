// Motion in time, driven by a TS of PETSc.
//
// Each implicit step minimises the incremental potential of dynamics.hpp by the SNES of the TS: Newton with the exact
// tangent, or its positive part while the exact one is indefinite, and backtracking on the energy. With contact no
// iteration goes further than it can without touching, and a step starts from where nothing is hit. A step that fails
// is repeated at a quarter of its size. The next step follows the number of iterations and, if asked for, the local
// error. The explicit method (-ts_type voile_central) is the central difference of the velocity-Verlet form with lumped
// mass; its step stays below 0.9 of the stability limit 2/omega_max, found by power iteration at the start and as the sheet stiffens. Options of TS, SNES, KSP
// and PC work as users know them: -ts_dt, -ts_max_time, -ts_max_steps, -ts_monitor, -ts_view, -ts_adapt_type (voile,
// none, basic ...), -snes_rtol ...
#pragma once

#include <memory>

#include "stepper.hpp"
#include "system/dynamics.hpp"
#include "time_options.hpp"

namespace voile::solve {

class TimeIntegration : public Stepper {
 public:
  /// Collective. `dynamics` must outlive it. `inexact`: systems are solved as exactly as a step needs (inexact_pc.hpp), by
  /// default; otherwise by a factor (mixed_pc.hpp).
  TimeIntegration(system::Dynamics& dynamics, TimeOptions options, bool inexact = true);
  ~TimeIntegration() override;

  /// A state without velocity is at rest; one without acceleration gets it from the equations, at the first step.
  [[nodiscard]] StepResult begin(system::State& state) override;
  [[nodiscard]] StepResult advance(system::State& state) override;
  [[nodiscard]] bool finished(const system::State& state) const override;
  /// From now on the motion of `state`, the one advanced so far, ends at this time instead of TimeOptions::until: the step
  /// that would go beyond is cut, the next one after a later end has the size that was wanted. After begin(). Collective. [s]
  void end_at(const system::State& state, double time);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Largest circular frequency of M^-1 K with the tangent at u and lumped mass, by power iteration [1/s]. Collective.
[[nodiscard]] double largest_frequency(system::Dynamics& dynamics, Vec u);

}  // namespace voile::solve

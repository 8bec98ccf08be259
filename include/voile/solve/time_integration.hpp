// Motion in time, driven by a TS of PETSc.
//
// Each implicit step minimises the incremental potential of dynamics.hpp by the SNES of the TS: Newton with the exact
// tangent, or its positive part while the exact one is indefinite, and backtracking on the energy. With contact no
// iteration goes further than it can without touching, and a step starts from where nothing is hit. A step that fails
// is repeated at a quarter of its size. The next step follows the number of iterations and, if asked for, the local
// error. The explicit method (-ts_type voile_central) is the central difference of the velocity-Verlet form with lumped
// mass; its step stays below 0.9 of the stability limit 2/omega_max, found by power iteration. Options of TS, SNES, KSP
// and PC work as users know them: -ts_dt, -ts_max_time, -ts_max_steps, -ts_monitor, -ts_view, -ts_adapt_type (voile,
// none, basic ...), -snes_rtol ...
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "voile/solve/newton.hpp"
#include "voile/solve/time_options.hpp"
#include "voile/system/dynamics.hpp"

namespace voile::solve {

/// A state in time. The vectors are not owned.
struct TimeState {
  int step = 0;
  double time = 0.0;       ///< [s]
  double next_step = 0.0;  ///< size of the step to come [s]; 0: as the options say
  Vec position = nullptr, velocity = nullptr;
  Vec acceleration = nullptr;  ///< null: found from the equations
};

/// One accepted step.
struct TimeReport {
  TimeState state;
  double taken = 0.0;  ///< size of the step [s]; 0 for the start
  NewtonResult newton;
  int rejections = 0;     ///< attempts that failed before
  int cut_short = 0;      ///< iterations that contact did not let go the whole way
  double shortest = 1.0;  ///< share of its increment that the most hindered iteration went
};

struct TimeResult {
  bool completed = false;
  bool stopped = false;  ///< by the observer, or by a signal (then with a reason)
  int steps = 0, newton_iterations = 0, factorisations = 0, rejections = 0;
  TimeState state;      ///< the last accepted one; vectors live as long as the TimeIntegration
  NewtonResult newton;  ///< of the last accepted step
  std::string reason;
};

class TimeIntegration {
 public:
  /// Called collectively with the start and every accepted step; returns true to end the run after it.
  using Observer = std::function<bool(const TimeReport&)>;
  using Remark = std::function<void(const std::string&)>;

  /// Collective. `dynamics` must outlive it.
  TimeIntegration(system::Dynamics& dynamics, TimeOptions options);
  ~TimeIntegration();
  TimeIntegration(const TimeIntegration&) = delete;
  TimeIntegration& operator=(const TimeIntegration&) = delete;

  void on_step(Observer observer);
  void on_remark(Remark remark);
  /// Moves from `start`, whose position and velocity are advanced in place, to the end time. Collective.
  [[nodiscard]] TimeResult run(const TimeState& start);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The options that change what the caller must know before a run: -ts_max_time. Not collective.
void read_time_options(TimeOptions& options);

/// Largest circular frequency of M^-1 K with the tangent at u and lumped mass, by power iteration [1/s]. Collective.
[[nodiscard]] double largest_frequency(system::Dynamics& dynamics, Vec u);

}  // namespace voile::solve

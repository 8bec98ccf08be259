// Parameters of motion in time.
#pragma once

#include <limits>

namespace voile::solve {

struct TimeOptions {
  enum class Method { implicit_alpha, central_difference };
  Method method = Method::implicit_alpha;
  double end_time = 1.0;  ///< [s]
  double until =
      std::numeric_limits<double>::infinity();  ///< another integration continues from there, if before the end [s]
  bool restarted = false;                       ///< from a state of another run, whose case may have been another
  bool released = false;                        ///< supports release where it begins, which changes the energy
  bool goes_on = false;                         ///< from another integration, which has shown the start to -ts_monitor
  double step = 0.01;                           ///< first step, and the largest unless max_step is larger [s]
  double min_step = 0.0;                        ///< a step that fails at this size ends the run [s]; 0: step/1000
  double max_step = 0.0;                        ///< [s]; 0: step
  double step_error = 0.0;                      ///< largest local error of a position per step [m]; 0: not controlled
  double radius = 0.5;                          ///< spectral radius at infinite frequency: 1 no dissipation, 0 the most
  int target_iterations = 10;                   ///< a step that needs more makes the next one smaller
  double velocity_tolerance = 0.0;  ///< an increment below this, as a root mean square over the mass and per step, ends
                                    ///< the iterations of a step [m/s]; 0: only the SNES's tolerances do
  bool energy_balance = false;      ///< whether State::balance is kept
};

}  // namespace voile::solve

// Parameters of the static path.
#pragma once

#include <string>
#include <vector>

namespace voile::solve {

/// How equilibria are followed from the unloaded state. Tolerances are the solver's own options (-snes_rtol ...).
struct StaticOptions {
  enum class Control { load, displacement, arc_length };
  enum class AtCriticalPoint { pass, stop, switch_branch };

  Control control = Control::load;
  double final_load_factor = 1.0;
  /// First increment. load: of the load factor; displacement: fraction of final_displacement; arc length: the length that
  /// such an increment of the load factor has at the start.
  double initial_step = 0.25;
  double min_step = 1e-6;  ///< below this a failing step ends the run (exit code 3)
  double max_step = 1.0;
  int max_steps = 1000;  ///< a path that has not ended by then is not converged
  std::vector<double>
      stops;  ///< load control: load factors that a step must end on, ascending; results are recorded there
  int target_iterations = 7;  ///< a step that needs fewer lets the next one grow by up to 2
  bool fallback = true;       ///< load control: pseudo-transient continuation before a step is halved twice

  // Displacement control and arc length
  std::string control_probe;        ///< name of the probe that is controlled or watched
  double final_displacement = 0.0;  ///< of that probe, where the path ends [m]; 0: it ends at final_load_factor
  AtCriticalPoint at_critical_point = AtCriticalPoint::pass;
  double branch_step = 1.0;  ///< first step along the mode in units of the step in force; its sign picks the side
};

}  // namespace voile::solve

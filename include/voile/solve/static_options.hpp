// Parameters of the static load path.
#pragma once

#include <vector>

namespace voile::solve {

/// How the load factor goes from 0 to `final`. Tolerances are the solver's own options (-snes_rtol ...).
struct StaticOptions {
  double final_load_factor = 1.0;
  double initial_step = 0.25;  ///< first increment of the load factor
  double min_step = 1e-6;      ///< below this a failing step ends the run (exit code 3)
  double max_step = 1.0;
  std::vector<double> stops;  ///< load factors that a step must end on, ascending; results are recorded there
  int target_iterations = 7;  ///< a step that needs fewer lets the next one grow by up to 2
  bool fallback = true;       ///< try pseudo-transient continuation before a step is halved below the first size
};

}  // namespace voile::solve

// What a run came to; private to src/app.
#pragma once

#include <vector>

#include "voile/solve/static_path.hpp"

namespace voile::app {

/// What summary.json says of a run.
struct Summary {
  bool converged = false;
  double load_factor = 0.0;
  int steps = 0, newton_iterations = 0, factorisations = 0;
  std::vector<solve::CriticalPoint> critical;
  std::vector<double> eigen;  ///< frequencies or critical load factors
  double time = 0.0;          ///< reached in a motion [s]
  long negative_pivots = -1;  ///< of the last tangent: the last state is unstable if > 0; -1: not known
  double residual = 0.0;      ///< relative, of the last state
};

}  // namespace voile::app

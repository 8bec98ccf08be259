// What contact remembers between steps.
#pragma once

#include <vector>

namespace voile::system {

/// What contact carries from step to step besides positions, alike on all ranks.
struct ContactMemory {
  /// How a start nearer than the activation distance is let out: smallest gap of each vertex then [m]; empty: not at all.
  std::vector<double> gaps;
  double start = 0.0;  ///< [s]
  /// Normal contact force on each vertex where the stage before has ended [N]; empty: not known.
  std::vector<double> push{};
  /// Which obstacles each vertex passes through: a sum of 2^k over them, k their number; empty: none.
  std::vector<double> passing;
};

}  // namespace voile::system

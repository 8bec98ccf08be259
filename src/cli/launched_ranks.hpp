// What the program that starts ranks tells each of them, for commands that do without MPI.
#pragma once

#include <string>

namespace voile::cli {

struct LaunchedRank {
  int rank = 0, size = 1;
  std::string job;  ///< one name for all ranks that were started together; empty: unknown, and the size then 1
};

/// From the environment of Open MPI, or of MPICH and its kin.
[[nodiscard]] LaunchedRank launched_rank();

/// Whether such a program has started this process: what its streams seem to be then says nothing of where they lead.
[[nodiscard]] bool is_launched();

}  // namespace voile::cli

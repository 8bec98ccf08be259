// How a case is run, beside the case itself: where its results go, from what it begins, how much it says.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "base/mpi.hpp"

namespace voile::setup {
class DrivenObstacles;
}

namespace voile::record {

enum class Verbosity { quiet, normal, verbose };

struct RunOptions {
  MPI_Comm comm = MPI_COMM_WORLD;
  std::filesystem::path output{};  ///< folder of the results; created; empty: nothing is written
  bool overwrite = false;          ///< an earlier run in that folder may be replaced
  std::filesystem::path
      restart{};          ///< results.vtkhdf of an earlier run to continue from; empty: from the unloaded state
  int restart_step = -1;  ///< its step; negative: the last one
  std::string from{};     ///< stage to begin with; empty: the first one
  Verbosity verbosity = Verbosity::normal;
  bool keep_history = false;                            ///< what history.csv would have is kept in memory, on rank 0
  std::shared_ptr<setup::DrivenObstacles> obstacles{};  ///< those that are put in place from outside; null: none are
};

}  // namespace voile::record

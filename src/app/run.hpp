// What the program does with a case: run, check, info. All are collective over the communicator that they are given, throw
// on every rank and print on rank 0 only.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "base/mpi.hpp"
#include "input/case.hpp"
#include "voile/errors.hpp"

namespace voile::app {

class DrivenObstacles;

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
  bool keep_history = false;                     ///< what history.csv would have is kept in memory, on rank 0
  std::shared_ptr<DrivenObstacles> obstacles{};  ///< those that are put in place from outside; null: none are
};

/// Solves the case and writes its results. Returns done, not_converged, or unstable where load control ends in an unstable
/// equilibrium.
[[nodiscard]] Exit run(const input::Case& c, const RunOptions& options);

/// Builds everything that a run would build and reports it, without solving. Throws UserError if anything is wrong.
void check(MPI_Comm comm, const input::Case& c);

/// Sizes, groups, quality, partition balance and patch condition numbers of a mesh (.msh, .geo) or of a case's mesh.
void info(MPI_Comm comm, const mesh::SurfaceMesh& mesh, const energy::ElementOptions& element);

/// Reads a mesh on rank 0 and distributes it. Collective. Throws UserError on every rank.
[[nodiscard]] mesh::SurfaceMesh load_mesh(MPI_Comm comm, const std::filesystem::path& file,
                                          const io::MeshOptions& options);

}  // namespace voile::app

// The stages of a run, resolved; private to src/app.
#pragma once

#include <vector>

#include "voile/app/run.hpp"
#include "voile/input/case.hpp"
#include "voile/system/model.hpp"

namespace voile::app {

/// One stage, with what PETSc's options say in force.
struct Stage {
  input::Case c;
  RunOptions options;  ///< with the folder of the stage
  system::ModelInput input;
};

/// A case without stages is one. Reads the files of obstacles, each once. Collective. Throws UserError.
[[nodiscard]] std::vector<Stage> stages_of(const input::Case& c, const RunOptions& options);

}  // namespace voile::app

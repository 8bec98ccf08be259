// Motion in time and draping; private to src/app.
#pragma once

#include <string>

#include "recorder.hpp"
#include "summary.hpp"
#include "voile/app/run.hpp"
#include "voile/input/case.hpp"
#include "voile/io/checkpoint.hpp"

namespace voile::app {

/// Collective. `model` is what `input` gives, with all supports; where supports let go, the run goes on with a model
/// without them, from the same state with the same size of step. `start` is what read_start gave.
[[nodiscard]] Summary run_dynamic(const input::Case& c, const RunOptions& options, const system::ModelInput& input,
                                  system::Model& model, Recorder& recorder, const io::Checkpoint& start,
                                  std::string& reason);
/// From and into `a`. Collective.
[[nodiscard]] Summary run_drape(const input::Case& c, system::Model& model, Recorder& recorder, Vec a,
                                std::string& reason);

}  // namespace voile::app

// Modes of vibration and buckling; private to src/app.
#pragma once

#include "input/case.hpp"
#include "run.hpp"
#include "summary.hpp"
#include "system/model.hpp"

namespace voile::app {

/// Modes about the state `a` into modes/ and modes.csv; appends them to the summary. Collective.
void run_modes(const input::Case& c, const RunOptions& options, system::Model& model, Vec a, Summary& summary);

}  // namespace voile::app

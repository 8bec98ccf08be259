// Modes of vibration and buckling; private to src/app.
#pragma once

#include "summary.hpp"
#include "voile/app/run.hpp"
#include "voile/input/case.hpp"
#include "voile/system/model.hpp"

namespace voile::app {

/// Modes about the state `a` into modes/ and modes.csv; appends them to the summary. Collective.
void run_modes(const input::Case& c, const RunOptions& options, system::Model& model, Vec a, Summary& summary);

}  // namespace voile::app

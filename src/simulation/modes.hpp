// Modes of vibration and buckling.
#pragma once

#include "input/case.hpp"
#include "record/run_options.hpp"
#include "record/summary.hpp"
#include "system/model.hpp"

namespace voile::simulation {

/// Modes about the state `a` into modes/ and modes.csv; appends them to the summary. Collective.
void run_modes(const input::Case& c, const record::RunOptions& options, system::Model& model, Vec a,
               record::Summary& summary);

}  // namespace voile::simulation

// Modes of vibration and buckling.
#pragma once

#include "input/case.hpp"
#include "record/run_options.hpp"
#include "record/summary.hpp"
#include "solve/eigen.hpp"
#include "system/model.hpp"

namespace voile::simulation {

/// Which modes of vibration are motions without strain: they have no energy to be wrong, and their frequencies are
/// round-off. Not collective.
[[nodiscard]] std::vector<char> rigid_modes(const input::Case& c, const system::Model& model,
                                            const std::vector<solve::Mode>& modes);
/// Modes about the state `a` into modes/ and modes.csv; appends them to the summary. Collective.
void run_modes(const input::Case& c, const record::RunOptions& options, system::Model& model, Vec a,
               record::Summary& summary);

}  // namespace voile::simulation

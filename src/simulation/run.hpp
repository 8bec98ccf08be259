// A whole case from its begin to its end.
#pragma once

#include "input/case.hpp"
#include "record/run_options.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

/// Solves the case and writes its results. Collective over the communicator of the options; throws on every rank and prints
/// on rank 0 only. Returns done, not_converged, or unstable where load control ends in an unstable
/// equilibrium.
[[nodiscard]] Exit run(const input::Case& c, const record::RunOptions& options);

}  // namespace voile::simulation

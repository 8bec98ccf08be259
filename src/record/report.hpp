// What a run says of its model before and of its work after.
#pragma once

#include <string>

#include "input/case.hpp"
#include "run_options.hpp"
#include "summary.hpp"
#include "system/model.hpp"

namespace voile::record {

/// Of the process since it began, summed over the ranks [s]. Collective.
[[nodiscard]] double cpu_seconds(MPI_Comm comm);

/// A line that names the units of a case and what labels in SI stand for; empty for SI. Not collective.
[[nodiscard]] std::string units_text(const input::Case& c);

/// Sizes, what the mesh lets expect, and what nothing holds; `first`: nothing has been said of the mesh. Collective.
/// Throws UserError where no equilibrium can be unique.
void report_model(const input::Case& c, const RunOptions& options, const system::Model& model, bool first);

/// The last words and summary.json. Collective.
void report_end(const input::Case& c, const RunOptions& options, const Summary& s);

}  // namespace voile::record

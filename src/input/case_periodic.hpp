// Periodic edges of a case; private to src/input.
#pragma once

#include "case_read.hpp"

namespace voile::input {

/// Reads the pairs of periodic edges of case `c`, whose [steps] are read. Throws UserError.
void read_periodics(const CaseReader& reader, Case& c);
/// Refuses what a case with periodic edges cannot have. Throws UserError.
void check_periodic(const Case& c);

}  // namespace voile::input

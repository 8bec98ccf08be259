// Rigid groups of a case; private to src/input.
#pragma once

#include "case_read.hpp"

namespace voile::input {

/// Completes a rigid group of case `c`, whose [steps] are read. Throws UserError.
void read_rigid(const SectionPlace& place, const Case& c, RigidSection& s);
/// Refuses what a case with rigid groups cannot have. Throws UserError.
void check_rigid(const Case& c);

}  // namespace voile::input

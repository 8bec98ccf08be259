// What a frequency response needs; private to src/input.
#pragma once

#include "case_read.hpp"

namespace voile::input {

/// Reads [eigen], [harmonic] and [damping], and checks them. After loads, materials and rigid groups. Throws UserError.
void read_harmonic(const CaseReader& reader, Case& c);
/// Checks what a frequency response cannot be about. After everything else is read. Throws UserError.
void check_harmonic(const Case& c);

}  // namespace voile::input

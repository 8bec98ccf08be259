// Supports as read, and motions from their texts; private to src/input.
#pragma once

#include <functional>

#include "case_read.hpp"

namespace voile::input {

using Motion = std::function<Vec3(const Vec3& rest, double time)>;

/// Turns the texts of a motion into a function; empty if there is none. `analyses`: that have one. Throws UserError.
[[nodiscard]] Motion motion_function(const SectionPlace& place, const MotionInput& m, bool possible,
                                     const char* analyses);

/// Reads the supports of a case with their motions. Throws UserError.
void read_supports(const CaseReader& reader, Case& c);

}  // namespace voile::input

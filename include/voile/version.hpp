// Voile's version.
#pragma once

#include <string>

#include "voile/api.hpp"

namespace voile {

/// Major, minor and patch, e.g. "0.1.0". Not collective.
[[nodiscard]] VOILE_API std::string version();

}  // namespace voile

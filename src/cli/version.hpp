// What this program consists of.
#pragma once

#include <string>

namespace voile::cli {

/// Voile's version and, one per line, those of the libraries it runs on. MPI must be initialised.
[[nodiscard]] std::string version_text();

}  // namespace voile::cli

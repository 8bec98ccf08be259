// `voile compare`: which modes of two runs are the same.
#pragma once

#include "voile/errors.hpp"

namespace voile::cli {

/// Whether the command line asks for it.
[[nodiscard]] bool is_compare(int argc, char** argv);
/// Reads the rest of the command line, compares, prints and writes. Before MPI starts. Throws UserError.
[[nodiscard]] Exit compare_command(int argc, char** argv);

}  // namespace voile::cli

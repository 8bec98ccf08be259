// `voile fit`: a fabric file from the measurements of a laboratory.
#pragma once

#include "voile/errors.hpp"

namespace voile::cli {

/// Whether the command line asks for it.
[[nodiscard]] bool is_fit(int argc, char** argv);
/// Reads the rest of the command line, fits, writes and prints. Before MPI starts. Throws UserError.
[[nodiscard]] Exit fit_command(int argc, char** argv);

}  // namespace voile::cli

// `voile fabric-test`: instruments of a laboratory as runs of the solver, for a fabric file.
//
// A strip that hangs over an edge (FAST-2), the loop of bending to 2.5 /cm (KES-FB2) and that of shear to 8 degrees (KES-FB1). What
// they read is written as a sheet that `voile fit` reads, and compared with the figures of the fabric file.
#pragma once

#include "voile/errors.hpp"

namespace voile::cli {

/// Whether the command line asks for it.
[[nodiscard]] bool is_fabric_test(int argc, char** argv);
/// Reads the rest of the command line, runs, writes and prints. Before MPI starts. Throws UserError.
[[nodiscard]] Exit fabric_test_command(int argc, char** argv);

}  // namespace voile::cli

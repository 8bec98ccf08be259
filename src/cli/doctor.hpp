// Whether this installation works: what `voile doctor` does.
#pragma once

namespace voile::cli {

/// Checks ranks, BLAS, programs, shipped files, Gmsh and HDF5, and solves a problem whose answer is published; prints one line
/// for each on rank 0. False if anything failed. Collective; PETSc must be running.
[[nodiscard]] bool doctor();

}  // namespace voile::cli

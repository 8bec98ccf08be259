// How many threads a rank uses.
#pragma once

namespace voile {

/// One thread per rank, unless OMP_NUM_THREADS or OPENBLAS_NUM_THREADS says otherwise: OpenBLAS would take one per core on every
/// rank, whose idle threads spin. Before any factorisation. Not collective.
void use_one_thread();

}  // namespace voile

// MPI, PETSc and SLEPc while a program uses Voile.
#pragma once

#include <memory>

#include "voile/api.hpp"

namespace voile {

/// Begins MPI, PETSc and SLEPc, those that nobody has begun yet, and ends those that it has begun. Simulations must be gone
/// before it goes. Options of PETSc on the command line and in PETSC_OPTIONS apply to all simulations. BLAS uses one thread
/// per rank unless OMP_NUM_THREADS or OPENBLAS_NUM_THREADS says otherwise.
class VOILE_API Session {
 public:
  /// Collective over MPI_COMM_WORLD. Throws InternalError if PETSc cannot be started.
  Session();
  Session(int argc, char** argv);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Of MPI_COMM_WORLD. Not collective.
  [[nodiscard]] int rank() const;

 private:
  void begin(int argc, char** argv);
  bool mpi_ = false, petsc_ = false;  ///< begun here
  std::shared_ptr<void> slepc_;
};

}  // namespace voile

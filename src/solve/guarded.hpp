// Exceptions must not cross PETSc's C frames; private to src/solve.
#pragma once

#include <petscsys.h>

#include <exception>
#include <string>

namespace voile::solve {

/// Runs `work`; an exception becomes a PETSc error and its text is kept for the caller.
template <class Work>
PetscErrorCode guarded(std::string& failure, Work&& work) {
  try {
    work();
  } catch (const std::exception& e) {
    failure = e.what();
    return PETSC_ERR_LIB;
  }
  return 0;
}

}  // namespace voile::solve

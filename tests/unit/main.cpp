// Starts MPI and PETSc once, runs the tests on every rank, and fails if any rank fails.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
#include <petscsys.h>

#include "voile/solve/eigen.hpp"

int main(int argc, char** argv) {
  if (PetscInitialize(nullptr, nullptr, nullptr, nullptr)) return 1;
  doctest::Context context(argc, argv);
  int failed = 0, worst = 0, rank = 0;
  {
    const voile::solve::SlepcSession slepc;
    failed = context.run();
  }
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Allreduce(&failed, &worst, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  PetscFinalize();
  return worst;
}

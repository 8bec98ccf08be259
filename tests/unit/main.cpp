// Starts MPI and PETSc once, runs the tests on every rank, and fails if any rank fails. On several ranks, folders and
// files whose tests know nothing of ranks are left out.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
#include <petscsys.h>

#include "voile/solve/eigen.hpp"

int main(int argc, char** argv) {
  if (PetscInitialize(nullptr, nullptr, nullptr, nullptr)) return 1;
  doctest::Context context(argc, argv);
  int failed = 0, worst = 0, size = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  if (size > 1)
    context.addFilter("source-file-exclude",
                      "*/adapt/*,*/contact/*,*/geometry/*,*/io/*,*/manikin/*,*/pattern/*,*/picture/*,*test_case.cpp,"
                      "*test_expression.cpp,*test_fabric.cpp,*test_laminate.cpp,*test_chord_correction.cpp,"
                      "*test_mesh_quality.cpp,*test_surface_mesh.cpp,*test_unfolding.cpp,*test_weld.cpp");
  {
    const voile::solve::SlepcSession slepc;
    failed = context.run();
  }
  MPI_Allreduce(&failed, &worst, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  PetscFinalize();
  return worst;
}

// Starts MPI and PETSc once, runs the tests on every rank, and fails if any rank fails or hangs. On several ranks, folders and
// files whose tests know nothing of ranks are left out.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
#include <petscsys.h>

#include "solve/eigen_options.hpp"
#include "watchdog.hpp"

REGISTER_LISTENER("watchdog", 1, voile::testing::Watched);

// Left out of runs of all tests; tests/run asks for it.
TEST_CASE("a reduction that one rank does not join" * doctest::skip()) {
  int rank = 0, sum = 0;
  MPI_Comm comm = MPI_COMM_NULL;
  MPI_Comm_dup(PETSC_COMM_WORLD, &comm);
  MPI_Comm_rank(comm, &rank);
  if (rank > 0) MPI_Allreduce(&rank, &sum, 1, MPI_INT, MPI_SUM, comm);
  CHECK(sum == 0);
  MPI_Comm_free(&comm);
}

int main(int argc, char** argv) {
  if (PetscInitialize(nullptr, nullptr, nullptr, nullptr)) return 1;
  doctest::Context context(argc, argv);
  int failed = 0, worst = 0, size = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  if (size > 1)
    context.addFilter("source-file-exclude",
                      "*/adapt/*,*/contact/*,*/formats/*,*/geometry/*,*/io/*,*/manikin/*,*/pattern/*,*/picture/*,"
                      "*/results/*,*test_case.cpp,*test_echo.cpp,*test_expression.cpp,*test_fabric.cpp,"
                      "*test_fabric_curves.cpp,*test_petsc_allowed.cpp,*test_unit_system.cpp,*test_failure.cpp,"
                      "*test_laminate.cpp,*test_chord_correction.cpp,*test_mesh_quality.cpp,*test_surface_mesh.cpp,"
                      "*test_unfolding.cpp,*test_weld.cpp");
  {
    const voile::solve::SlepcSession slepc;
    failed = context.run();
  }
  voile::testing::watchdog().expect("the end of all test cases, where ranks wait for each other,", 2.0);
  MPI_Allreduce(&failed, &worst, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  PetscFinalize();
  return worst;
}

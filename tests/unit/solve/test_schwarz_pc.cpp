// Overlapping subdomains with a coarse level of rigid motions: iterations on a plate, whatever the number of subdomains.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/petsc.hpp"
#include "solve/schwarz_pc.hpp"

namespace {

using namespace voile;

/// A square plate by finite differences, n x n nodes, clamped along i = 0: squares of second differences for z, first ones for x and
/// y, in full 3 x 3 blocks.
struct Plate {
  PetscInt n, begin = 0, end = 0;
  petsc::MatHandle k;
  std::vector<double> places;

  explicit Plate(PetscInt size) : n(size) {
    VOILE_PETSC(MatCreate(PETSC_COMM_WORLD, k.out()));
    VOILE_PETSC(MatSetBlockSize(k, 3));
    VOILE_PETSC(MatSetSizes(k, PETSC_DECIDE, PETSC_DECIDE, 3 * n * n, 3 * n * n));
    VOILE_PETSC(MatSetType(k, MATAIJ));
    VOILE_PETSC(MatSetUp(k));
    VOILE_PETSC(MatSetOption(k, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
    VOILE_PETSC(MatGetOwnershipRange(k, &begin, &end));
    for (PetscInt i = 0; i < n; ++i)
      for (PetscInt j = 0; j < n; ++j) {
        for (const auto& [di, dj] : {std::pair{1, 0}, {0, 1}}) {
          add({{{i, j, -1.0}, {i + di, j + dj, 1.0}, {i, j, 0.0}}}, 1e3, 0, 2);
          add({{{i, j, -2.0}, {i + di, j + dj, 1.0}, {i - di, j - dj, 1.0}}}, 1.0, 2, 3);
        }
        if (i == 0) add({{{i, j, 1.0}, {i, j, 0.0}, {i, j, 0.0}}}, 2.0, 0, 3);
        if (i == 0) add({{{i, j, -1.0}, {i + 1, j, 1.0}, {i, j, 0.0}}}, 2.0, 2, 3);
        add({{{i, j, 1.0}, {i, j + 1, -2.0}, {i + 1, j, 1.0}}}, 1e-3, 2, 3);
      }
    VOILE_PETSC(MatAssemblyBegin(k, MAT_FINAL_ASSEMBLY));
    VOILE_PETSC(MatAssemblyEnd(k, MAT_FINAL_ASSEMBLY));
    for (PetscInt node = begin / 3; node < end / 3; ++node)
      for (const double c : {static_cast<double>(node / n), static_cast<double>(node % n), 0.0}) places.push_back(c);
  }
  struct Weight {
    PetscInt i, j;
    double value;
  };
  /// The square of a difference, in some components; what lies beside the plate is left out.
  void add(const std::array<Weight, 3>& difference, double stiffness, int from, int to) {
    for (const Weight& a : difference)
      if (a.i < 0 || a.i >= n || a.j < 0 || a.j >= n) return;
    for (const Weight& a : difference)
      for (const Weight& b : difference)
        for (PetscInt r = 0; r < 3; ++r)
          for (PetscInt c = 0; c < 3; ++c) {
            const PetscInt row = 3 * (n * a.i + a.j) + r, column = 3 * (n * b.i + b.j) + c;
            if (row < begin || row >= end) continue;
            const double value = r == c && r >= from && r < to ? stiffness * a.value * b.value : 0.0;
            VOILE_PETSC(MatSetValue(k, row, column, value, ADD_VALUES));
          }
  }
};

struct Found {
  int iterations;
  double residual;
};

Found solve_with(Plate& plate, int vertices, int smoothing) {
  solve::register_schwarz_pc();
  petsc::KspHandle ksp;
  PC pc = nullptr;
  VOILE_PETSC(PetscOptionsSetValue(nullptr, "-t_pc_schwarz_vertices", std::to_string(vertices).c_str()));
  VOILE_PETSC(PetscOptionsSetValue(nullptr, "-t_pc_schwarz_smoothing", std::to_string(smoothing).c_str()));
  VOILE_PETSC(KSPCreate(PETSC_COMM_WORLD, ksp.out()));
  VOILE_PETSC(KSPSetOptionsPrefix(ksp, "t_"));
  VOILE_PETSC(KSPSetType(ksp, KSPCG));
  VOILE_PETSC(KSPSetTolerances(ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 300));
  VOILE_PETSC(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  VOILE_PETSC(PCSetType(pc, solve::schwarz_pc_type));
  VOILE_PETSC(KSPSetFromOptions(ksp));
  VOILE_PETSC(PCSetCoordinates(pc, 3, static_cast<PetscInt>(plate.places.size() / 3), plate.places.data()));
  for (const char* name : {"-t_pc_schwarz_vertices", "-t_pc_schwarz_smoothing"})
    VOILE_PETSC(PetscOptionsClearValue(nullptr, name));
  petsc::VecHandle b, x, r;
  VOILE_PETSC(MatCreateVecs(plate.k, b.out(), x.out()));
  VOILE_PETSC(VecDuplicate(b, r.out()));
  VOILE_PETSC(VecSet(b, 1.0));
  VOILE_PETSC(KSPSetOperators(ksp, plate.k, plate.k));
  VOILE_PETSC(KSPSolve(ksp, b, x));
  PetscInt iterations = 0;
  double size = 0.0, left = 0.0;
  VOILE_PETSC(KSPGetIterationNumber(ksp, &iterations));
  VOILE_PETSC(MatMult(plate.k, x, r));
  VOILE_PETSC(VecAXPY(r, -1.0, b));
  VOILE_PETSC(VecNorm(b, NORM_2, &size));
  VOILE_PETSC(VecNorm(r, NORM_2, &left));
  return {static_cast<int>(iterations), left / size};
}

}  // namespace

TEST_CASE("Schwarz: iterations do not grow with the number of subdomains, and need smooth shares") {
  Plate plate(40);
  const Found few = solve_with(plate, 400, 3), many = solve_with(plate, 50, 3), rough = solve_with(plate, 50, 0);
  MESSAGE(few.iterations << ", " << many.iterations << ", " << rough.iterations << " iterations");
  CHECK(few.residual < 1e-7);
  CHECK(many.residual < 1e-7);
  CHECK(few.iterations < 45);
  CHECK(many.iterations < 45);
  CHECK(rough.iterations > 1.5 * many.iterations);
}

// The direct solver that factors in single precision: answers in double, inertia, fallback, change of pattern.
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "base/petsc.hpp"
#include "linear/mixed_pc.hpp"

namespace test_mixed_pc {

namespace {

using namespace voile;
using KspHandle = petsc::Handle<KSP, KSPDestroy>;

/// Three unknowns per node of an n x n grid, neighbours joined by a full 3 x 3 block of rank one plus `weak` times
/// the identity, `shift` on the diagonal; `bridge` joins the first node with the last.
struct Grid {
  int n;
  double weak, shift;
  petsc::MatHandle k;

  Grid(int size, double weak_part, double diagonal) : n(size), weak(weak_part), shift(diagonal) { build(false); }

  void build(bool bridge) {
    const PetscInt rows = 3 * n * n;
    VOILE_PETSC(MatCreate(PETSC_COMM_WORLD, k.out()));
    VOILE_PETSC(MatSetSizes(k, PETSC_DECIDE, PETSC_DECIDE, rows, rows));
    VOILE_PETSC(MatSetBlockSize(k, 3));
    VOILE_PETSC(MatSetType(k, MATAIJ));
    VOILE_PETSC(MatSetUp(k));
    PetscInt begin = 0, end = 0;
    VOILE_PETSC(MatGetOwnershipRange(k, &begin, &end));
    for (PetscInt node = begin / 3; node < end / 3; ++node) {
      add(node, node, shift, 0.0);
      for (const auto& [di, dj] : {std::array{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
        const int i = static_cast<int>(node) / n + di, j = static_cast<int>(node) % n + dj;
        if (i >= 0 && i < n && j >= 0 && j < n) join(node, i * n + j);
      }
      if (bridge && node == 0) join(0, n * n - 1);
      if (bridge && node == n * n - 1) join(node, 0);
    }
    VOILE_PETSC(MatAssemblyBegin(k, MAT_FINAL_ASSEMBLY));
    VOILE_PETSC(MatAssemblyEnd(k, MAT_FINAL_ASSEMBLY));
  }
  /// Row of blocks of a bond.
  void join(PetscInt a, PetscInt b) {
    add(a, a, weak, 1.0);
    add(a, b, -weak, -1.0);
  }
  void add(PetscInt a, PetscInt b, double identity, double stiff) {
    const std::array<double, 3> d{0.6, 0.0, 0.8};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        const PetscInt row = 3 * a + r, column = 3 * b + c;
        VOILE_PETSC(MatSetValue(k, row, column, stiff * d[r] * d[c] + (r == c ? identity : 0.0), ADD_VALUES));
      }
  }
};

/// Beam of 400 cells by finite differences, (w'')^2, clamped at one end, on a foundation: condition number 5e10. Two of three
/// unknowns of a node are held by springs of their own.
struct Beam {
  petsc::MatHandle k;

  explicit Beam(double foundation) {
    constexpr PetscInt nodes = 400;
    VOILE_PETSC(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, 3 * nodes, 3 * nodes, 5, nullptr, 5, nullptr,
                             k.out()));
    for (PetscInt c = 0; c < nodes - 1; ++c) {
      const std::array<double, 3> bend{1.0, -2.0, 1.0};
      for (PetscInt i = 0; i < 3; ++i)
        for (PetscInt j = 0; j < 3; ++j)
          if (c + i > 0 && c + j > 0) add(3 * (c + i - 1), 3 * (c + j - 1), bend[i] * bend[j]);
    }
    add(0, 0, 5.0);
    for (PetscInt i = 0; i < nodes; ++i) {
      add(3 * i, 3 * i, foundation);
      for (PetscInt c : {1, 2}) add(3 * i + c, 3 * i + c, 1.0);
    }
    VOILE_PETSC(MatAssemblyBegin(k, MAT_FINAL_ASSEMBLY));
    VOILE_PETSC(MatAssemblyEnd(k, MAT_FINAL_ASSEMBLY));
  }
  void add(PetscInt row, PetscInt column, double value) {
    PetscInt begin = 0, end = 0;
    VOILE_PETSC(MatGetOwnershipRange(k, &begin, &end));
    if (row >= begin && row < end) VOILE_PETSC(MatSetValue(k, row, column, value, ADD_VALUES));
  }
};

struct Solver {
  KspHandle ksp;
  PC pc = nullptr;

  Solver() {
    linear::register_mixed_pc();
    VOILE_PETSC(KSPCreate(PETSC_COMM_WORLD, ksp.out()));
    VOILE_PETSC(KSPSetType(ksp, KSPPREONLY));
    VOILE_PETSC(KSPGetPC(ksp, &pc));
    VOILE_PETSC(PCSetType(pc, linear::mixed_pc_type));
  }
  /// |b - K x| / |b| with K x = b solved for a b that varies over the grid.
  [[nodiscard]] double residual(Mat k) {
    petsc::VecHandle b, x, r;
    VOILE_PETSC(MatCreateVecs(k, b.out(), x.out()));
    VOILE_PETSC(VecDuplicate(b, r.out()));
    PetscInt begin = 0, end = 0;
    VOILE_PETSC(VecGetOwnershipRange(b, &begin, &end));
    for (PetscInt i = begin; i < end; ++i)
      VOILE_PETSC(VecSetValue(b, i, std::sin(static_cast<double>(i * i)), INSERT_VALUES));
    VOILE_PETSC(VecAssemblyBegin(b));
    VOILE_PETSC(VecAssemblyEnd(b));
    VOILE_PETSC(KSPSetOperators(ksp, k, k));
    VOILE_PETSC(KSPSolve(ksp, b, x));
    VOILE_PETSC(MatMult(k, x, r));
    VOILE_PETSC(VecAXPY(r, -1.0, b));
    double size = 0.0, left = 0.0;
    VOILE_PETSC(VecNorm(b, NORM_2, &size));
    VOILE_PETSC(VecNorm(r, NORM_2, &left));
    return left / size;
  }
};

}  // namespace

TEST_CASE("mixed precision: solutions are those of double precision, also after a change of pattern") {
  Grid grid(12, 1e-3, 1e-2);
  Solver solver;
  CHECK(solver.residual(grid.k) < 1e-8);
  CHECK(linear::mixed_negative_pivots(solver.pc) == 0);
  CHECK(linear::mixed_double_factors(solver.pc) == 0);
  grid.build(true);
  CHECK(solver.residual(grid.k) < 1e-8);
  CHECK(linear::mixed_negative_pivots(solver.pc) == 0);
}

#ifdef __SSE__
TEST_CASE("mixed precision: what is too small for normal floats counts as zero, here only") {
  petsc::MatHandle one;
  VOILE_PETSC(MatCreateAIJ(PETSC_COMM_SELF, 2, 2, 2, 2, 1, nullptr, 0, nullptr, one.out()));
  for (PetscInt i = 0; i < 2; ++i) VOILE_PETSC(MatSetValue(one, i, i, 1.0, INSERT_VALUES));
  VOILE_PETSC(MatAssemblyBegin(one, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(one, MAT_FINAL_ASSEMBLY));
  petsc::VecHandle b, x;
  VOILE_PETSC(MatCreateVecs(one, b.out(), x.out()));
  VOILE_PETSC(VecSetValue(b, 0, 1.0, INSERT_VALUES));
  VOILE_PETSC(VecSetValue(b, 1, 1e-40, INSERT_VALUES));
  VOILE_PETSC(VecAssemblyBegin(b));
  VOILE_PETSC(VecAssemblyEnd(b));
  linear::register_mixed_pc();
  KspHandle ksp;
  VOILE_PETSC(KSPCreate(PETSC_COMM_SELF, ksp.out()));
  VOILE_PETSC(KSPSetType(ksp, KSPPREONLY));
  PC pc = nullptr;
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  VOILE_PETSC(PCSetType(pc, linear::mixed_pc_type));
  VOILE_PETSC(KSPSetOperators(ksp, one, one));
  VOILE_PETSC(KSPSolve(ksp, b, x));
  const petsc::ReadArray values(x);
  CHECK(values[0] == 1.0);
  CHECK(values[1] == 0.0);
  const volatile float small = 1e-38f;
  CHECK(small * 0.01f > 0.0f);
}
#endif

TEST_CASE("mixed precision: negative pivots are negative eigenvalues") {
  // A negative definite matrix, and one whose only negative eigenvalue is that of the three translations.
  Grid negative(6, 1e-3, -100.0);
  Solver first;
  VOILE_PETSC(KSPSetOperators(first.ksp, negative.k, negative.k));
  VOILE_PETSC(KSPSetUp(first.ksp));
  CHECK(linear::mixed_negative_pivots(first.pc) == 3 * 36);
  Grid loose(6, 1.0, -1e-2);  // the next eigenvalue is 1 - 2 cos(pi/6) + 1 = 0.27
  Solver second;
  VOILE_PETSC(KSPSetOperators(second.ksp, loose.k, loose.k));
  VOILE_PETSC(KSPSetUp(second.ksp));
  CHECK(linear::mixed_negative_pivots(second.pc) == 3);
}

TEST_CASE("mixed precision: a factor that round-off has made indefinite is shifted") {
  const Beam beam(0.0);
  Solver solver;
  CHECK(solver.residual(beam.k) < 1e-7);
  CHECK(linear::mixed_double_factors(solver.pc) == 0);
  CHECK(linear::mixed_negative_pivots(solver.pc) == -1);
}

TEST_CASE("mixed precision: in statics a negative mode below the round-off of the factor is found, and no other") {
  // Euler & Bernoulli's clamped beam: (1.8751/400)^4 = 4.83e-10 is the lowest eigenvalue, (4.694/400)^4 = 1.9e-8 the next.
  for (const double foundation : {0.0, -4.4e-10, -5.2e-10, -1.8e-8, -2.1e-8}) {
    const Beam beam(foundation);
    Solver solver;
    linear::set_mixed_proves(solver.pc);
    VOILE_PETSC(KSPSetOperators(solver.ksp, beam.k, beam.k));
    VOILE_PETSC(KSPSetUp(solver.ksp));
    const long negative = foundation > -4.83e-10 ? 0 : foundation > -1.9e-8 ? 1 : 2;
    CAPTURE(foundation);
    CHECK(linear::mixed_negative_pivots(solver.pc) == negative);
    CHECK(linear::mixed_double_factors(solver.pc) == (negative > 0 ? 1 : 0));
    CHECK(linear::mixed_negative_pivots(solver.pc) == negative);  // and is known from then on
    CHECK(solver.residual(beam.k) < 1e-5);                        // 1e-16 of the condition number, 5e10 and more
  }
}

TEST_CASE("mixed precision: a factor on disk is the same factor") {
  const Grid grid(12, 1e-3, 1e-2);
  Solver here, on_disk;
  VOILE_PETSC(KSPSetOptionsPrefix(on_disk.ksp, "disk_"));
  VOILE_PETSC(PetscOptionsSetValue(nullptr, "-disk_pc_mixed_on_disk", "1"));
  VOILE_PETSC(KSPSetFromOptions(on_disk.ksp));
  VOILE_PETSC(PetscOptionsClearValue(nullptr, "-disk_pc_mixed_on_disk"));
  CHECK(on_disk.residual(grid.k) == doctest::Approx(here.residual(grid.k)));
  CHECK(linear::mixed_double_factors(on_disk.pc) == 0);
}

TEST_CASE("mixed precision: in statics two failures are enough") {
  Grid indefinite(6, 1.0, -1e-2), definite(6, 1.0, 1.0);
  for (const bool statics : {false, true}) {
    Solver solver;
    if (statics) linear::set_mixed_proves(solver.pc);
    const auto rounds = [&](Mat k, int count) {
      for (int round = 0; round < count; ++round) {
        VOILE_PETSC(MatScale(k, round % 2 == 0 ? 2.0 : 0.5));  // another matrix to the solver
        CHECK(solver.residual(k) < 1e-7);
      }
    };
    rounds(indefinite.k, 1);
    rounds(definite.k, 11);
    CHECK(linear::mixed_double_factors(solver.pc) == 11);
    rounds(indefinite.k, 1);
    rounds(definite.k, 12);
    CHECK(linear::mixed_double_factors(solver.pc) == (statics ? 24 : 22));
  }
}

TEST_CASE("mixed precision: what single precision cannot do is done in double") {
  // Condition number 1e10: the weak directions are lost in the round-off of floats, and six digits of K x in that of
  // doubles.
  Grid grid(12, 1e-8, 1e-10);
  Solver solver;
  CHECK(solver.residual(grid.k) < 1e-6);
  // An indefinite matrix is no matter for conjugate gradients.
  Grid indefinite(6, 1.0, -1e-2);
  Solver other;
  CHECK(other.residual(indefinite.k) < 1e-10);
  CHECK(linear::mixed_double_factors(other.pc) == 1);
  CHECK(linear::mixed_negative_pivots(other.pc) == 3);
}

}  // namespace test_mixed_pc

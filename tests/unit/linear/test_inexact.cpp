// Systems solved only as exactly as Newton's method needs: tolerances, negative curvature, fallback, motion with it.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "extent.hpp"
#include "linear/inexact_pc.hpp"
#include "solve/time_integration.hpp"
#include "test_blocks.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_inexact {

namespace {

using namespace voile;
using namespace voile::testing;
using KspHandle = petsc::Handle<KSP, KSPDestroy>;

/// n nodes in a chain, springs of stiffness 1 across all three axes, `shift` on the diagonal.
struct Chain {
  static constexpr int n = 60;
  petsc::MatHandle k;
  explicit Chain(double shift) {
    const PetscInt rows = 3 * n;
    VOILE_PETSC(MatCreate(PETSC_COMM_WORLD, k.out()));
    PetscInt own = PETSC_DECIDE, blocks = n;
    VOILE_PETSC(PetscSplitOwnership(PETSC_COMM_WORLD, &own, &blocks));
    VOILE_PETSC(MatSetSizes(k, 3 * own, 3 * own, rows, rows));
    VOILE_PETSC(MatSetBlockSize(k, 3));
    VOILE_PETSC(MatSetType(k, MATAIJ));
    VOILE_PETSC(MatSetUp(k));
    fill(shift);
  }
  void fill(double shift) {
    PetscInt begin = 0, end = 0;
    VOILE_PETSC(MatGetOwnershipRange(k, &begin, &end));
    for (PetscInt i = begin / 3; i < end / 3; ++i) {
      const double bonds = (i > 0 ? 1.0 : 0.0) + (i < n - 1 ? 1.0 : 0.0);
      set(i, i, bonds + shift);
      if (i > 0) set(i, i - 1, -1.0);
      if (i < n - 1) set(i, i + 1, -1.0);
    }
    VOILE_PETSC(MatAssemblyBegin(k, MAT_FINAL_ASSEMBLY));
    VOILE_PETSC(MatAssemblyEnd(k, MAT_FINAL_ASSEMBLY));
  }
  void set(PetscInt a, PetscInt b, double value) {
    for (PetscInt r = 0; r < 3; ++r)
      for (PetscInt c = 0; c < 3; ++c)
        VOILE_PETSC(MatSetValue(k, 3 * a + r, 3 * b + c, r == c ? value : 0.0, INSERT_VALUES));
  }
};

struct Solver {
  KspHandle ksp;
  PC pc = nullptr;
  explicit Solver(Mat k) {
    linear::register_inexact_pc();
    VOILE_PETSC(KSPCreate(PETSC_COMM_WORLD, ksp.out()));
    VOILE_PETSC(KSPSetType(ksp, KSPPREONLY));
    VOILE_PETSC(KSPGetPC(ksp, &pc));
    VOILE_PETSC(PCSetType(pc, linear::inexact_pc_type));
    VOILE_PETSC(KSPSetOperators(ksp, k, k));
  }
  /// |b - K x| / |b| of a solution for b that varies along the chain.
  [[nodiscard]] double residual(Mat k) {
    petsc::VecHandle b, x, r;
    VOILE_PETSC(MatCreateVecs(k, b.out(), x.out()));
    VOILE_PETSC(VecDuplicate(b, r.out()));
    PetscInt begin = 0, end = 0;
    VOILE_PETSC(VecGetOwnershipRange(b, &begin, &end));
    for (PetscInt i = begin; i < end; ++i) VOILE_PETSC(VecSetValue(b, i, std::sin(1.0 * i * i), INSERT_VALUES));
    VOILE_PETSC(VecAssemblyBegin(b));
    VOILE_PETSC(VecAssemblyEnd(b));
    for (const double factor : {2.0, 0.5}) VOILE_PETSC(MatScale(k, factor));  // as if assembled anew
    VOILE_PETSC(KSPSolve(ksp, b, x));
    VOILE_PETSC(MatMult(k, x, r));
    VOILE_PETSC(VecAXPY(r, -1.0, b));
    double size = 0.0, left = 0.0;
    VOILE_PETSC(VecNorm(b, NORM_2, &size));
    VOILE_PETSC(VecNorm(r, NORM_2, &left));
    return left / size;
  }
};

/// A sheet held along one edge that begins to fall.
struct Falling {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle u, v;

  Falling() : mesh(data()), model(PETSC_COMM_WORLD, mesh, input()), u(model.dofs().create_vector()) {
    v = model.dofs().create_vector();
  }
  static mesh::MeshData data() {
    mesh::MeshData d = grid(12, 6, false, 0.0);
    add_square_groups(d);
    return mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.5 * x[1], 0.0); });
  }
  static system::ModelInput input() {
    system::ModelInput in;
    in.materials = {isotropic(1e5, 0.3, 0.002, 0.5)};
    in.supports = {support("left", system::Support::Kind::clamped)};
    in.loads = {load(system::Load::Kind::gravity, "", Vec3(0.0, 0.0, -9.81))};
    return in;
  }
};

struct Motion {
  Ended ended;
  std::vector<double> end;
};

/// From a state, of another run or none, to 0.04 s in steps of 2 ms; `stop`: number of the step to end with.
Motion fall(int stop = -1, const Motion* from = nullptr, const system::State* middle = nullptr) {
  Falling f;
  system::Dynamics dynamics(f.model, {});
  solve::TimeOptions o;
  o.end_time = 0.04;
  o.step = 0.002;
  o.target_iterations = 100;
  solve::TimeIntegration time(dynamics, o);
  system::State start = state_of(f.u, f.v);
  if (from && middle) {
    start.a = f.model.dofs().create_vector();
    const std::size_t n = from->end.size() / 3;
    const auto part = [&](std::size_t k) {
      return std::vector<double>(from->end.begin() + static_cast<long>(k * n),
                                 from->end.begin() + static_cast<long>((k + 1) * n));
    };
    f.model.dofs().scatter(part(0), f.u);
    f.model.dofs().scatter(part(1), f.v);
    f.model.dofs().scatter(part(2), start.a);
    start.step = middle->step;
    start.time = middle->time;
    start.next_step = middle->next_step;
    start.solver = middle->solver;
  }
  Motion m;
  m.ended = follow_from(std::move(start), time,
                        [&](const system::State& s, const solve::StepResult&) { return s.step == stop; });
  for (Vec x :
       {static_cast<Vec>(m.ended.state.u), static_cast<Vec>(m.ended.state.v), static_cast<Vec>(m.ended.state.a)}) {
    const std::vector<double> values = values_of(f.model, x);
    m.end.insert(m.end.end(), values.begin(), values.end());
  }
  return m;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double off = 0.0, size = 0.0;
  for (std::size_t i = 0; i < a.size() / 3; ++i) {  // displacements
    off = std::max(off, std::abs(a[i] - b[i]));
    size = std::max(size, std::abs(b[i]));
  }
  return off / size;
}

}  // namespace

TEST_CASE("inexact: as exact as asked for, and as can be without being asked") {
  const Option poor("-inexact_pc_type", "jacobi"), many("-inexact_ksp_max_it", "200");
  Chain chain(0.1);
  Solver solver(chain.k);
  CHECK(solver.residual(chain.k) < 1e-10);
  const long exactly = linear::inexact_counts(solver.pc).iterations;
  linear::set_inexact_tolerance(solver.pc, 0.03);
  const double rough = solver.residual(chain.k);
  CHECK(rough < 0.1);
  CHECK(rough > 1e-6);
  CHECK(2 * (linear::inexact_counts(solver.pc).iterations - exactly) < exactly);
  // The caller may want small solutions right.
  linear::InexactCallbacks callbacks;
  callbacks.is_last = [](void*, Vec, PetscBool* last) {
    *last = PETSC_TRUE;
    return PetscErrorCode(0);
  };
  linear::set_inexact_callbacks(solver.pc, callbacks);
  CHECK(solver.residual(chain.k) < 1e-3);
  CHECK(linear::inexact_counts(solver.pc).factors == 0);
}

TEST_CASE("inexact: what would take longer than a factor is factored, and so are the next ones, a few at first") {
  const Option few("-inexact_ksp_max_it", "1"), poor("-inexact_pc_type", "jacobi");
  Chain chain(1e-3);
  Solver solver(chain.k);
  for (int solution = 1; solution <= 9; ++solution) CHECK(solver.residual(chain.k) < 1e-8);
  CHECK(linear::inexact_counts(solver.pc).factors == 9);
  CHECK(linear::inexact_counts(solver.pc).solutions == 0);
  CHECK(linear::inexact_memory(solver.pc).factors_left == 0);
  const long before = linear::inexact_counts(solver.pc).iterations;
  CHECK(solver.residual(chain.k) < 1e-8);  // tried again, in vain
  CHECK(linear::inexact_counts(solver.pc).iterations == before + 1);
  CHECK(linear::inexact_memory(solver.pc).factors_left == 16);
}

TEST_CASE("inexact: negative curvature is met with a positive matrix, or with a factor") {
  // Only the long waves have negative stiffness: every block of the diagonal is positive, and so is the incomplete factor
  // of some ranks.
  Chain chain(-5e-3);
  Solver solver(chain.k);
  CHECK(solver.residual(chain.k) < 1e-8);
  CHECK(linear::inexact_counts(solver.pc).factors == 1);
  CHECK(linear::inexact_negative_pivots(solver.pc) > 0);
  Chain second(-5e-3);
  Solver other(second.k);
  linear::InexactCallbacks callbacks;
  callbacks.context = &second;
  callbacks.make_positive = [](void* c, PetscBool* changed) {
    static_cast<Chain*>(c)->fill(5e-3);
    *changed = PETSC_TRUE;
    return PetscErrorCode(0);
  };
  linear::set_inexact_callbacks(other.pc, callbacks);
  CHECK(other.residual(second.k) < 1e-8);
  CHECK(linear::inexact_counts(other.pc).negative_curvature == 1);
  CHECK(linear::inexact_counts(other.pc).factors == 0);
  CHECK(linear::inexact_negative_pivots(other.pc) == -1);
}

namespace {

/// Solutions as exact as can be of a strip of about that many vertices, by voile_inexact as it is without other options.
linear::InexactCounts inexact_solution(int vertices, int across, double ground) {
  const petsc::MatHandle k = stiff_strip(vertices / across / mpi::size(PETSC_COMM_WORLD), across, ground);
  const petsc::VecHandle b = right_side(k);
  petsc::VecHandle x;
  Solver solver(k);
  VOILE_PETSC(KSPSetFromOptions(solver.ksp));
  VOILE_PETSC(VecDuplicate(b, x.out()));
  VOILE_PETSC(KSPSolve(solver.ksp, b, x));
  return linear::inexact_counts(solver.pc);
}

}  // namespace

TEST_CASE("inexact: a coarse level from 15 000 vertices on") {
  for (const int vertices : {14400, 15600}) {
    if (extent(false, vertices < 15000)) continue;
    const long usual = inexact_solution(vertices, 60, 1e-2).iterations;
    const Option none("-inexact_pc_block_icc_aggregates", "0");
    const long without = inexact_solution(vertices, 60, 1e-2).iterations;
    CAPTURE(vertices);
    CAPTURE(without);
    if (vertices < 15000)
      CHECK(usual == without);
    else
      CHECK(2 * usual < without);
  }
}

TEST_CASE("inexact: three iterations per square root of the vertices are worth a factor, more are not") {
  const Option poor("-inexact_pc_type", "jacobi");
  const double root = 40.0;
  const linear::InexactCounts some = inexact_solution(1600, 20, 0.2), many = inexact_solution(1600, 20, 1e-3);
  CHECK(some.solutions == 1);
  CHECK(static_cast<double>(some.iterations) > 1.5 * root);
  CHECK(static_cast<double>(some.iterations) < 3.0 * root);
  CHECK(many.solutions == 0);
  CHECK(many.factors == 1);
  const Option earlier("-pc_inexact_break_even", "1");
  CHECK(inexact_solution(1600, 20, 0.2).factors == 1);
}

TEST_CASE("motion: iterations and factors end in the same state") {
  const Motion inexact = fall();
  REQUIRE(inexact.ended.completed);
  CHECK(inexact.ended.factorisations == 0);
  CHECK(inexact.ended.iterative.solutions >= inexact.ended.newton_iterations);
  const Option cholesky("-pc_type", "cholesky");
  const Motion exact = fall();
  CHECK(exact.ended.iterative.solutions == 0);
  CHECK(exact.ended.factorisations > 0);
  CHECK(difference(inexact.end, exact.end) < 1e-6);
}

TEST_CASE("motion: where iterations never suffice, factors do; a continued run remembers it") {
  const Option few("-inexact_ksp_max_it", "2");
  const Motion whole = fall();
  REQUIRE(whole.ended.completed);
  CHECK(whole.ended.factorisations > 20);
  const Option cholesky("-pc_type", "cholesky");
  const Motion exact = fall();
  VOILE_PETSC(PetscOptionsClearValue(nullptr, "-pc_type"));
  CHECK(difference(whole.end, exact.end) < 1e-6);
  const Motion part = fall(7);
  REQUIRE(part.ended.state.solver.wait > 0);
  const Motion rest = fall(-1, &part, &part.ended.state);
  CHECK(part.ended.factorisations + rest.ended.factorisations == whole.ended.factorisations);
  CHECK(difference(rest.end, whole.end) < 1e-12);
}

}  // namespace test_inexact

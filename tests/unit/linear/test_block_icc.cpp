// The incomplete factor of 3 x 3 blocks: exact where elimination makes no fill, else that of the textbook; breakdowns.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <optional>

#include "base/decompositions.hpp"
#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "base/types.hpp"
#include "linear/block_icc_pc.hpp"
#include "test_blocks.hpp"
#include "test_model_kit.hpp"
#include "voile/errors.hpp"

namespace test_block_icc {

namespace {

using namespace voile;
using namespace voile::testing;
using KspHandle = petsc::Handle<KSP, KSPDestroy>;
using Dense = Eigen::MatrixXd;

constexpr int nodes = 12;  ///< per rank

/// A matrix of which each rank has the same diagonal part `own`; with `coupling`, neighbours on two ranks are joined.
petsc::MatHandle distributed(const Dense& own, double coupling = 0.0) {
  const auto rows = static_cast<PetscInt>(own.rows());
  petsc::MatHandle k = empty_matrix(rows);
  PetscInt first = 0, end = 0, all = 0;
  VOILE_PETSC(MatGetOwnershipRange(k, &first, &end));
  VOILE_PETSC(MatGetSize(k, &all, nullptr));
  for (PetscInt i = 0; i < rows / 3; ++i)
    for (PetscInt j = 0; j < rows / 3; ++j) {
      if (own.block<3, 3>(3 * i, 3 * j).isZero(0.0)) continue;
      for (PetscInt r = 3 * i; r < 3 * i + 3; ++r)
        for (PetscInt c = 3 * j; c < 3 * j + 3; ++c)
          VOILE_PETSC(MatSetValue(k, first + r, first + c, own(r, c), INSERT_VALUES));
    }
  for (PetscInt r = 0; r < 3 && coupling != 0.0; ++r)
    for (PetscInt c = 0; c < 3; ++c) {
      const double value = r == c ? coupling : 0.0;
      if (first > 0) VOILE_PETSC(MatSetValue(k, first + r, first - 3 + c, value, INSERT_VALUES));
      if (end < all) VOILE_PETSC(MatSetValue(k, end - 3 + r, end + c, value, INSERT_VALUES));
    }
  VOILE_PETSC(MatAssemblyBegin(k, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(k, MAT_FINAL_ASSEMBLY));
  return k;
}

/// Symmetric and positive definite: random blocks between nodes that `joined` joins, and enough on the diagonal.
Dense spd(const std::function<bool(int, int)>& joined) {
  std::srand(7);
  Dense a = Dense::Zero(3 * nodes, 3 * nodes);
  for (int i = 0; i < nodes; ++i)
    for (int j = 0; j < i; ++j) {
      if (!joined(i, j)) continue;
      const Mat3 b = Mat3::Random();
      a.block<3, 3>(3 * i, 3 * j) = b;
      a.block<3, 3>(3 * j, 3 * i) = b.transpose();
    }
  for (int i = 0; i < nodes; ++i) {
    const Mat3 b = Mat3::Random();
    a.block<3, 3>(3 * i, 3 * i) = b * b.transpose();
  }
  const double least = eigenvalues(a)[0];
  a.diagonal().array() += 0.1 - least;
  return a;
}

bool on_chain(int i, int j) {
  return i == j + 1;
}
bool on_grid(int i, int j) {  // four in a row, with one diagonal
  return (i == j + 1 && i % 4 != 0) || i == j + 4 || (i == j + 5 && i % 4 != 0);
}

/// W D W^T with the pattern of a, from the definition: entry (i, j) of it is that of a where a has one.
Dense textbook(const Dense& a) {
  Dense w = Dense::Identity(a.rows(), a.rows()), d = Dense::Zero(a.rows(), a.rows());
  for (Eigen::Index i = 0; i < a.rows(); i += 3)
    for (Eigen::Index j = 0; j <= i; j += 3) {
      Mat3 left = a.block<3, 3>(i, j);
      if (left.isZero(0.0)) continue;
      for (Eigen::Index m = 0; m < j; m += 3)
        left -= w.block<3, 3>(i, m) * d.block<3, 3>(m, m) * w.block<3, 3>(j, m).transpose();
      if (i == j)
        d.block<3, 3>(i, i) = left;
      else
        w.block<3, 3>(i, j) = left * d.block<3, 3>(j, j).inverse();
    }
  return w * d * w.transpose();
}

struct Solver {
  KspHandle ksp;
  PC pc = nullptr;
  explicit Solver(Mat k, KSPType type = KSPCG) {
    linear::register_block_icc_pc();
    VOILE_PETSC(KSPCreate(PETSC_COMM_WORLD, ksp.out()));
    VOILE_PETSC(KSPSetType(ksp, type));
    VOILE_PETSC(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, 200));
    VOILE_PETSC(KSPGetPC(ksp, &pc));
    VOILE_PETSC(PCSetType(pc, linear::block_icc_pc_type));
    VOILE_PETSC(KSPSetOperators(ksp, k, k));
  }
};

/// |x - P^-1 b| / |x| of one application on this rank's part, with PETSc's order of this name, or the default.
double error_of_application(Mat k, const Dense& p, const char* order = nullptr) {
  Solver solver(k);
  const Option apart("-pc_block_icc_overlap", "0");
  std::optional<Option> ordered;
  if (order) ordered.emplace("-pc_block_icc_ordering_type", order);
  VOILE_PETSC(PCSetFromOptions(solver.pc));
  const petsc::VecHandle b = right_side(k);
  petsc::VecHandle x;
  VOILE_PETSC(VecDuplicate(b, x.out()));
  VOILE_PETSC(PCSetUp((VOILE_PETSC(KSPSetUp(solver.ksp)), solver.pc)));
  VOILE_PETSC(PCApply(solver.pc, b, x));
  CHECK(linear::block_icc_shift(solver.pc) == 0.0);
  const petsc::ReadArray right(b), left(x);
  const Eigen::Map<const Eigen::VectorXd> vb(right.data(), p.rows()), vx(left.data(), p.rows());
  return (vx - LeastSquares(p).solve(vb)).norm() / vx.norm();
}

/// Kershaw's matrix: positive definite, but its incomplete factor has a negative pivot. As blocks.
Dense kershaw() {
  Eigen::Matrix4d a;
  a << 3, -2, 0, 2, -2, 3, -2, 0, 0, -2, 3, -2, 2, 0, -2, 3;
  Dense blocks = Dense::Zero(12, 12);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) blocks.block<3, 3>(3 * i, 3 * j) = a(i, j) * Mat3::Identity();
  return blocks;
}

}  // namespace

TEST_CASE("incomplete factor: exact for a chain of blocks, on each rank's part") {
  const Dense a = spd(on_chain);
  for (const double coupling : {0.0, 0.05}) CHECK(error_of_application(distributed(a, coupling), a) < 1e-5);
}

TEST_CASE("incomplete factor: that of the textbook where elimination would make fill") {
  const Dense a = spd(on_grid), p = textbook(a);
  REQUIRE((p - a).norm() > 1e-2 * a.norm());  // it does
  CHECK(error_of_application(distributed(a), p, MATORDERINGNATURAL) < 1e-5);
}

TEST_CASE("incomplete factor: a chain numbered to and fro is put in order first") {
  const auto place = [](int i) { return 5 * i % nodes; };  // along the chain
  const Dense a = spd([&](int i, int j) { return std::abs(place(i) - place(j)) == 1; });
  CHECK(error_of_application(distributed(a), a) < 1e-5);
  CHECK(error_of_application(distributed(a), a, MATORDERINGNATURAL) > 1e-3);
}

TEST_CASE("incomplete factor: new values in the same pattern, then another pattern") {
  const Dense a = spd(on_chain), g = spd(on_grid);
  const petsc::MatHandle k = distributed(a), other = distributed(g);
  Solver solver(k);
  const petsc::VecHandle b = right_side(k);
  petsc::VecHandle x, y;
  for (petsc::VecHandle* v : {&x, &y}) VOILE_PETSC(VecDuplicate(b, v->out()));
  VOILE_PETSC(KSPSetUp(solver.ksp));
  VOILE_PETSC(PCApply(solver.pc, b, x));
  VOILE_PETSC(MatScale(k, 4.0));
  VOILE_PETSC(KSPSetUp(solver.ksp));
  VOILE_PETSC(PCApply(solver.pc, b, y));
  VOILE_PETSC(VecAXPY(y, -0.25, x));
  double off = 0.0, size = 0.0;
  VOILE_PETSC(VecNorm(y, NORM_2, &off));
  VOILE_PETSC(VecNorm(x, NORM_2, &size));
  CHECK(off < 1e-6 * size);
  VOILE_PETSC(KSPSetOperators(solver.ksp, other, other));
  VOILE_PETSC(KSPSolve(solver.ksp, b, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  VOILE_PETSC(KSPGetConvergedReason(solver.ksp, &reason));
  CHECK(reason > 0);
}

TEST_CASE("incomplete factor: a breakdown is met with a shift, an indefinite block is a failure") {
  const petsc::MatHandle k = distributed(kershaw(), 0.01);
  Solver solver(k);
  const petsc::VecHandle b = right_side(k);
  petsc::VecHandle x, r;
  for (petsc::VecHandle* v : {&x, &r}) VOILE_PETSC(VecDuplicate(b, v->out()));
  VOILE_PETSC(KSPSolve(solver.ksp, b, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  VOILE_PETSC(KSPGetConvergedReason(solver.ksp, &reason));
  CHECK(reason > 0);
  CHECK(linear::block_icc_shift(solver.pc) > 0.0);
  CHECK(linear::block_icc_shifted(solver.pc) == 1);
  VOILE_PETSC(MatMult(k, x, r));
  VOILE_PETSC(VecAXPY(r, -1.0, b));
  double left = 0.0, size = 0.0;
  VOILE_PETSC(VecNorm(r, NORM_2, &left));
  VOILE_PETSC(VecNorm(b, NORM_2, &size));
  CHECK(left < 1e-8 * size);
  Solver strict(k);
  linear::allow_block_icc_shifts(strict.pc, false);
  VOILE_PETSC(KSPSetUp(strict.ksp));
  PCFailedReason refused = PC_NOERROR;
  VOILE_PETSC(PCGetFailedReason(strict.pc, &refused));
  CHECK(refused != PC_NOERROR);
  // On one rank only, so that the others must be told.
  Dense bad = spd(on_chain);
  if (mpi::rank(PETSC_COMM_WORLD) == 0) bad(4, 4) = -1.0;
  const petsc::MatHandle indefinite = distributed(bad);
  Solver second(indefinite);
  VOILE_PETSC(KSPSetUp(second.ksp));
  PCFailedReason failed = PC_NOERROR;
  VOILE_PETSC(PCGetFailedReason(second.pc, &failed));
  CHECK(failed != PC_NOERROR);
}

TEST_CASE("incomplete factor: a matrix of other blocks is refused with words") {
  petsc::MatHandle thin;
  VOILE_PETSC(
      MatCreateAIJ(PETSC_COMM_WORLD, 4, 4, PETSC_DETERMINE, PETSC_DETERMINE, 1, nullptr, 0, nullptr, thin.out()));
  VOILE_PETSC(MatAssemblyBegin(thin, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(thin, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatShift(thin, 1.0));
  Solver solver(thin);
  VOILE_PETSC(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));  // PETSc's own would end the process
  const PetscErrorCode code = KSPSetUp(solver.ksp);
  VOILE_PETSC(PetscPopErrorHandler());
  CHECK(code == PETSC_ERR_SUP);
  CHECK_THROWS_AS(petsc::check(code, "KSPSetUp"), UserError);
}

namespace {

petsc::VecHandle applied(PC pc, Vec b) {
  petsc::VecHandle x;
  VOILE_PETSC(VecDuplicate(b, x.out()));
  VOILE_PETSC(PCApply(pc, b, x));
  return x;
}

/// Iterations to the solver's tolerance.
PetscInt iterations_with(Mat k, int aggregates, bool overlap = true) {
  Solver solver(k);
  const Option given("-pc_block_icc_overlap", overlap ? "1" : "0");
  VOILE_PETSC(PCSetFromOptions(solver.pc));
  linear::set_block_icc_aggregates(solver.pc, aggregates);
  const petsc::VecHandle b = right_side(k);
  petsc::VecHandle x;
  PetscInt count = 0;
  VOILE_PETSC(VecDuplicate(b, x.out()));
  VOILE_PETSC(KSPSolve(solver.ksp, b, x));
  VOILE_PETSC(KSPGetIterationNumber(solver.ksp, &count));
  return count;
}

}  // namespace

TEST_CASE("incomplete factor with an overlap: the sum over the ranks' parts, each joined to its neighbours") {
  constexpr double coupling = 0.05;
  const Dense a = spd(on_chain);
  const Eigen::Index own = a.rows(), first = own * mpi::rank(PETSC_COMM_WORLD), all = own * mpi::size(PETSC_COMM_WORLD);
  const petsc::MatHandle k = distributed(a, coupling);
  const petsc::VecHandle b = right_side(k);
  Dense whole = Dense::Zero(all, all);
  Eigen::VectorXd right(all), expected = Eigen::VectorXd::Zero(all);
  for (Eigen::Index at = 0; at < all; at += own) {
    whole.block(at, at, own, own) = a;
    right.segment(at, own) = Eigen::Map<const Eigen::VectorXd>(petsc::ReadArray(b).data(), own);
  }
  for (Eigen::Index at = own; at < all; at += own)
    for (Eigen::Index r = 0; r < 3; ++r) whole(at + r, at - 3 + r) = whole(at - 3 + r, at + r) = coupling;
  for (Eigen::Index at = 0; at < all; at += own) {
    const Eigen::Index from = std::max<Eigen::Index>(at - 3, 0), count = std::min(at + own + 3, all) - from;
    expected.segment(from, count) +=
        LeastSquares(whole.block(from, from, count, count)).solve(right.segment(from, count));
  }
  Solver solver(k);
  for (const double scale : {1.0, 0.5}) {  // and of new values in the same pattern
    VOILE_PETSC(MatScale(k, scale));
    VOILE_PETSC(KSPSetUp(solver.ksp));
    const petsc::VecHandle x = applied(solver.pc, b);
    const Eigen::VectorXd got = Eigen::Map<const Eigen::VectorXd>(petsc::ReadArray(x).data(), own);
    CHECK((scale * got - expected.segment(first, own)).norm() < 1e-5 * got.norm());
  }
}

TEST_CASE(
    "incomplete factor with an overlap: fewer iterations on several ranks where couplings reach over two vertices, as "
    "of bending") {
  const petsc::MatHandle springs = stiff_strip(30, 60, 0.0);
  petsc::MatHandle k;
  VOILE_PETSC(MatMatMult(springs, springs, MAT_INITIAL_MATRIX, PETSC_DEFAULT, k.out()));
  VOILE_PETSC(MatShift(k, 0.1));
  const bool alone = mpi::size(PETSC_COMM_WORLD) == 1;
  for (const int aggregates : {0, 16}) {
    const PetscInt with = iterations_with(k, aggregates), without = iterations_with(k, aggregates, false);
    CAPTURE(aggregates);
    CAPTURE(with);
    CAPTURE(without);
    CHECK((alone ? with == without : 4 * with < 3 * without));
  }
}

TEST_CASE("incomplete factor with a coarse level: symmetric, positive, exact for what the whole does together") {
  const petsc::MatHandle k = stiff_strip(60, 12);
  Solver solver(k);
  linear::set_block_icc_aggregates(solver.pc, 8);
  VOILE_PETSC(KSPSetUp(solver.ksp));
  const petsc::VecHandle b = right_side(k);
  petsc::VecHandle c, shift, force;
  for (auto* v : {&c, &shift, &force}) VOILE_PETSC(VecDuplicate(b, v->out()));
  VOILE_PETSC(VecPointwiseMult(c, b, b));
  const petsc::VecHandle pb = applied(solver.pc, b), pc = applied(solver.pc, c);
  CHECK(std::abs(dot(b, pc) - dot(c, pb)) < 1e-5 * std::abs(dot(b, pc)));
  CHECK(dot(b, pb) > 0.0);
  VOILE_PETSC(VecSet(shift, 1.0));
  VOILE_PETSC(MatMult(k, shift, force));
  const petsc::VecHandle back = applied(solver.pc, force);
  VOILE_PETSC(VecAXPY(back, -1.0, shift));
  double off = 0.0;
  VOILE_PETSC(VecNorm(back, NORM_INFINITY, &off));
  CHECK(off < 1e-3);
}

TEST_CASE("incomplete factor with a coarse level: fewer iterations for a stiff sheet") {
  const petsc::MatHandle k = stiff_strip(60, 12);
  const PetscInt with = iterations_with(k, 8 * mpi::size(PETSC_COMM_WORLD)), without = iterations_with(k, 0);
  CAPTURE(with);
  CAPTURE(without);
  CHECK(3 * with < 2 * without);
}

TEST_CASE(
    "incomplete factor with a coarse level: none for a matrix that is not positive there, nor for no aggregates") {
  const petsc::MatHandle k = stiff_strip(60, 12, -1e-3);
  const petsc::VecHandle b = right_side(k);
  Solver with(k), without(k);
  linear::set_block_icc_aggregates(with.pc, 8);
  for (Solver* s : {&with, &without}) VOILE_PETSC(KSPSetUp(s->ksp));
  const petsc::VecHandle x = applied(with.pc, b), y = applied(without.pc, b);
  PetscBool same = PETSC_FALSE;
  VOILE_PETSC(VecEqual(x, y, &same));
  CHECK(same);
  CHECK(dot(b, x) > 0.0);
  for (const char* number : {"-1", "2001"}) {
    const Option given("-pc_block_icc_aggregates", number);
    VOILE_PETSC(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));  // PETSc's own would end the process
    const PetscErrorCode code = PCSetFromOptions(with.pc);
    VOILE_PETSC(PetscPopErrorHandler());
    CHECK(code == PETSC_ERR_USER_INPUT);
  }
}

}  // namespace test_block_icc

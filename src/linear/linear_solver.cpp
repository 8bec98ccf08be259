#include "linear_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "block_icc_pc.hpp"
#include "inertia.hpp"
#include "inexact_pc.hpp"
#include "low_rank_solution.hpp"
#include "mixed_pc.hpp"
#include "voile/errors.hpp"

namespace voile::linear {

namespace {

constexpr int workspace_retries = 5;
/// From here on single precision saves memory at no cost of time.
constexpr PetscInt vertices_of_mixed = 10000;

/// Part of the right-hand side that a solution may leave without being called inexact.
constexpr double left_unsolved = 1e-2;

/// Whether the user tunes the factor in double, which then has to be one.
bool factor_is_tuned() {
  char* all = nullptr;
  VOILE_PETSC(PetscOptionsGetAll(nullptr, &all));
  const std::string_view options(all);
  const bool tuned = options.find("-mat_mumps_") != options.npos || options.find("-pc_factor_") != options.npos;
  VOILE_PETSC(PetscFree(all));
  return tuned;
}

}  // namespace

LinearSolver::LinearSolver(system::Model& model) : model_(model), low_rank_(std::make_unique<LowRankSolution>()) {}
LinearSolver::~LinearSolver() = default;

void LinearSolver::set_defaults(KSP ksp, Method method) {
  register_mixed_pc();
  register_block_icc_pc();
  register_inexact_pc();
  ksp_ = ksp;
  PC pc = nullptr;
  VOILE_PETSC(KSPSetType(ksp_, KSPPREONLY));
  VOILE_PETSC(KSPGetPC(ksp_, &pc));
  const bool large = model_.dofs().unknowns() >= 3 * vertices_of_mixed;
  if (!model_.conditions().symmetric())
    VOILE_PETSC(PCSetType(pc, PCLU));
  else if (method == Method::inexact && !model_.conditions().has_gas())
    VOILE_PETSC(PCSetType(pc, inexact_pc_type));
  else if (method != Method::direct)
    VOILE_PETSC(PCSetType(pc, mixed_pc_type));
  else
    VOILE_PETSC(PCSetType(pc, large && !factor_is_tuned() ? mixed_pc_type : PCCHOLESKY));
  statics_ = method == Method::direct;
}

void LinearSolver::prepare() {
  PC pc = nullptr;
  VOILE_PETSC(KSPGetPC(ksp_, &pc));
  PetscBool cholesky = PETSC_FALSE, lu = PETSC_FALSE, is_mumps = PETSC_FALSE, given = PETSC_FALSE, mixed = PETSC_FALSE,
            inexact = PETSC_FALSE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &cholesky));
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCLU, &lu));
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), mixed_pc_type, &mixed));
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), inexact_pc_type, &inexact));
  mixed_ = mixed;
  inexact_ = inexact;
  PetscBool direct = PETSC_FALSE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp_), KSPPREONLY, &direct));
  trusted_ = direct && (mixed || inexact || ((cholesky || lu) && !factor_is_tuned()));
  if (mixed_ && statics_) set_mixed_proves(pc);
  if (model_.conditions().has_gas() && !(direct && (mixed || cholesky || lu)))
    throw UserError(
        "[[load]] type 'gas' couples all vertices, which needs a complete factor: leave out -ksp_type and -pc_type, or "
        "choose -pc_type cholesky, lu or voile_mixed");
  if (!cholesky && !lu) return;
  MatSolverType type = nullptr;
  VOILE_PETSC(PCFactorGetMatSolverType(pc, &type));
  if (!type) {
    // Options that were read with the matrix at hand, as for a motion, have made a factor of PETSc's own: it would stay.
    VOILE_PETSC(PCReset(pc));
    VOILE_PETSC(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  }
  VOILE_PETSC(PCFactorGetMatSolverType(pc, &type));
  VOILE_PETSC(PetscStrcmp(type, MATSOLVERMUMPS, &is_mumps));
  mumps_ = is_mumps;
  cholesky_ = cholesky;
  pattern_version_ = model_.tangent().pattern_version();
  if (!mumps_) return;
  VOILE_PETSC(KSPSetOperators(ksp_, model_.tangent().matrix(), model_.tangent().matrix()));
  // On one rank PETSc would hand its own ordering to MUMPS's LU, inverted, and for small matrices one that MUMPS
  // refuses.
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-pc_factor_mat_ordering_type", &given));
  if (lu && !given) VOILE_PETSC(PCFactorSetMatOrderingType(pc, MATORDERINGEXTERNAL));
  VOILE_PETSC(PCFactorSetUpMatSolverType(pc));
  if (lu) VOILE_PETSC(MatMumpsSetIcntl(factor(), mumps_finds_determinant, 1));
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-mat_mumps_icntl_14", &given));
  // MUMPS's own 20 % fails at random in parallel.
  if (!given) VOILE_PETSC(MatMumpsSetIcntl(factor(), mumps_workspace_percent, 100));
}

Mat LinearSolver::factor() const {
  PC pc = nullptr;
  Mat f = nullptr;
  VOILE_PETSC(KSPGetPC(ksp_, &pc));
  VOILE_PETSC(PCFactorGetMatrix(pc, &f));
  return f;
}

PC LinearSolver::inexact() const {
  PC pc = nullptr;
  if (inexact_) VOILE_PETSC(KSPGetPC(ksp_, &pc));
  return pc;
}

int LinearSolver::factorisations() const {
  return inexact_ ? static_cast<int>(inexact_counts(inexact()).factors) : factorisations_;
}

long LinearSolver::negative_pivots() const {
  const long sparse = sparse_pivots();
  if (sparse < 0 || change().empty()) return sparse;
  PC pc = nullptr;
  VOILE_PETSC(KSPGetPC(ksp_, &pc));
  low_rank_->prepare(pc, change());
  return sparse + low_rank_->more_negative(change());
}

long LinearSolver::sparse_pivots() const {
  if (inexact_) return inexact_negative_pivots(inexact());
  if (mixed_ && factorisations_ > 0) {
    PC pc = nullptr;
    VOILE_PETSC(KSPGetPC(ksp_, &pc));
    return mixed_negative_pivots(pc);
  }
  if (!mumps_ || !cholesky_ || factorisations_ == 0) return -1;  // an LU has no signs that tell
  PetscInt count = 0;
  VOILE_PETSC(MatMumpsGetInfog(factor(), mumps_negative_pivots, &count));
  return count;
}

int LinearSolver::determinant_sign() const {
  if (!mumps_ || cholesky_ || factorisations_ == 0) return 0;
  double mantissa = 0.0;
  VOILE_PETSC(MatMumpsGetRinfog(factor(), mumps_determinant, &mantissa));
  return mantissa > 0.0 ? 1 : mantissa < 0.0 ? -1 : 0;
}

NegativeEigenvalues LinearSolver::count_negative() {
  const bool symmetric = model_.conditions().symmetric();
  if (const long known = symmetric ? negative_pivots() : -1; known >= 0 || !change().empty()) return {known, known};
  const Inertia inertia = inertia_of(model_.tangent().matrix());
  const long count = inertia.negative;
  if (symmetric || inertia.conservative || count <= 0) return {count, count};
  const int sign = determinant_sign();
  if (sign == 0) return {};
  // A real eigenvalue that passes zero turns the sign, a complex pair does not.
  const bool odd = sign < 0;
  const long likely = (count % 2 == 1) == odd ? count : count - 1;
  return {odd ? likely : -1, likely};
}

long LinearSolver::certain_negative_eigenvalues() {
  constexpr double round_off = 1e-13;
  constexpr long motions = 6;  // that nothing resists, of a body: more negative eigenvalues are not of them alone
  const long count = negative_eigenvalues();
  if (count <= 0 || count > motions || !change().empty()) return count;
  petsc::MatHandle raised;
  VOILE_PETSC(MatDuplicate(model_.tangent().matrix(), MAT_COPY_VALUES, raised.out()));
  petsc::VecHandle diagonal = model_.dofs().create_vector();
  VOILE_PETSC(MatGetDiagonal(raised, diagonal));
  VOILE_PETSC(VecAbs(diagonal));
  VOILE_PETSC(VecScale(diagonal, round_off));
  VOILE_PETSC(MatDiagonalSet(raised, diagonal, ADD_VALUES));
  const long certain = inertia_of(raised).negative;
  return certain < 0 ? count : std::min(count, certain);
}

void check_mumps_room(int error, int size) {
  if (error == -90)
    throw UserError(
        "the direct solver MUMPS could not keep its factor in files (INFOG(1) = -90): the folder that the environment "
        "variable MUMPS_OOC_TMPDIR names, /tmp without it, must exist, be writable on all machines and have room");
  switch (error) {
    case -5:   // analysis, reals
    case -7:   // analysis, integers
    case -13:  // factorisation
    case -19:  // beyond -mat_mumps_icntl_23
      break;
    default:
      return;
  }
  // MUMPS gives what it asked for in entries, or, where negative, in millions of them.
  const double entries = size >= 0 ? size : -1e6 * size;
  throw UserError(fmt::format(
      "out of memory: the direct solver MUMPS asked for another {:.3g} GB (INFOG(1) = {}) and did not get it. More "
      "ranks "
      "on more machines, or a coarser mesh, need less per process; -pc_type voile_mixed (single precision, the default "
      "of large symmetric statics) halves the factor; -mat_mumps_icntl_22 1 keeps it on disk",
      8e-9 * entries, error));
}

bool LinearSolver::repair(int attempt) {
  if (!mumps_ || factorisations_ == 0) return false;
  PetscInt error = 0, percent = 0;
  VOILE_PETSC(MatMumpsGetInfog(factor(), mumps_error, &error));
  if (error >= 0) return false;
  PetscInt size = 0;
  VOILE_PETSC(MatMumpsGetInfog(factor(), mumps_error + 1, &size));
  check_mumps_room(error, size);
  // PETSc refuses to factor again after an error of MUMPS, silently: only a new factor object helps.
  VOILE_PETSC(MatMumpsGetIcntl(factor(), mumps_workspace_percent, &percent));
  const bool lacks_workspace = error == -8 || error == -9;
  if (lacks_workspace) percent = std::max<PetscInt>(100, 2 * percent);
  // The symbolic factorisation reads the options again: the user's value, found too small, must not come back.
  PetscBool given = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-mat_mumps_icntl_14", &given));
  if (given) VOILE_PETSC(PetscOptionsSetValue(nullptr, "-mat_mumps_icntl_14", fmt::format("{}", percent).c_str()));
  renew_factor(percent);
  failure_ = fmt::format("MUMPS error {}", error);
  return lacks_workspace && attempt < workspace_retries;
}

void LinearSolver::renew_factor(PetscInt workspace_percent) {
  low_rank_->forget();
  PC pc = nullptr;
  VOILE_PETSC(KSPGetPC(ksp_, &pc));
  VOILE_PETSC(PCReset(pc));
  VOILE_PETSC(KSPSetOperators(ksp_, model_.tangent().matrix(), model_.tangent().matrix()));
  VOILE_PETSC(PCFactorSetUpMatSolverType(pc));
  VOILE_PETSC(MatMumpsSetIcntl(factor(), mumps_workspace_percent, workspace_percent));
  if (!cholesky_) VOILE_PETSC(MatMumpsSetIcntl(factor(), mumps_finds_determinant, 1));
}

void LinearSolver::tangent_changed() {
  ++factorisations_;
  low_rank_->forget();
  if (std::exchange(pattern_version_, model_.tangent().pattern_version()) == model_.tangent().pattern_version() ||
      !mumps_)
    return;
  PetscInt percent = 0;
  VOILE_PETSC(MatMumpsGetIcntl(factor(), mumps_workspace_percent, &percent));
  renew_factor(percent);
}

bool LinearSolver::solve(Vec rhs, Vec x) {
  for (int attempt = 0;; ++attempt) {
    VOILE_PETSC(KSPSetOperators(ksp_, model_.tangent().matrix(), model_.tangent().matrix()));
    completed_ = false;
    VOILE_PETSC(KSPSolve(ksp_, rhs, x));
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    VOILE_PETSC(KSPGetConvergedReason(ksp_, &reason));
    if (reason > 0) {
      if (!completed_) complete_solution(rhs, x);
      return true;
    }
    if (!repair(attempt)) return false;
    ++factorisations_;
  }
}

void LinearSolver::complete_solution(Vec rhs, Vec x) {
  completed_ = true;
  if (!change().empty()) {
    PC pc = nullptr;
    VOILE_PETSC(KSPGetPC(ksp_, &pc));
    low_rank_->prepare(pc, change());
    low_rank_->correct(change(), x);
  }
  check_solution(rhs, x);
}

double LinearSolver::part_left(Vec rhs, Vec x) const {
  const petsc::VecHandle rest = model_.dofs().create_vector();
  double size = 0.0, left = 0.0;
  model_.tangent().multiply(x, rest);
  VOILE_PETSC(VecAXPY(rest, -1.0, rhs));
  VOILE_PETSC(VecNorm(rhs, NORM_2, &size));
  VOILE_PETSC(VecNorm(rest, NORM_2, &left));
  return size > 0.0 ? left / size : left;
}

void LinearSolver::check_solution(Vec rhs, Vec x) {
  solved_ = (trusted_ && change().empty()) || part_left(rhs, x) <= left_unsolved;
}

bool LinearSolver::solve_to(double most_left, Vec rhs, Vec x) {
  if (!solve(rhs, x)) return false;
  const bool good = part_left(rhs, x) <= most_left;
  if (!good) failure_ = "its residual is too large";
  return good;
}

bool LinearSolver::factorise() {
  for (int attempt = 0;; ++attempt) {
    VOILE_PETSC(KSPSetOperators(ksp_, model_.tangent().matrix(), model_.tangent().matrix()));
    VOILE_PETSC(KSPSetUp(ksp_));
    PC pc = nullptr;
    PCFailedReason reason = PC_NOERROR;
    VOILE_PETSC(KSPGetPC(ksp_, &pc));
    VOILE_PETSC(PCGetFailedReason(pc, &reason));
    if (reason == PC_NOERROR) return true;
    if (!repair(attempt)) return false;
    ++factorisations_;
  }
}

std::string LinearSolver::take_failure() {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  VOILE_PETSC(KSPGetConvergedReason(ksp_, &reason));
  if (!failure_.empty() || reason >= 0) return std::exchange(failure_, {});
  std::string text = KSPConvergedReasons[reason];
  // Far from equilibrium the tangent of a thin shell has negative eigenvalues even where the equilibrium is stable.
  if (reason == KSP_DIVERGED_INDEFINITE_PC || reason == KSP_DIVERGED_INDEFINITE_MAT)
    text +=
        ": the tangent is indefinite there, which conjugate gradients cannot solve; the direct solver (the default) "
        "and -ksp_type gmres or minres can";
  else if (reason == KSP_DIVERGED_ITS)
    text += ": not enough iterations; raise -ksp_max_it, or use the direct solver (the default)";
  return text;
}

}  // namespace voile::linear

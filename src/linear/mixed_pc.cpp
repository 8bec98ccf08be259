#include "mixed_pc.hpp"

#include <fmt/format.h>
#include <petsc/private/pcimpl.h>

#include <algorithm>
#include <array>
#include <memory>

#include "base/petsc.hpp"
#include "linear_solver.hpp"
#include "mumps_single.hpp"
#include "voile/errors.hpp"

namespace voile::linear {

namespace {

/// After single precision has failed, so many matrices are factored in double before it is tried again.
constexpr int double_factors_after_failure = 10;

/// The diagonal times 1 + shift is what one factor after the other has, where conjugate gradients find the one before indefinite.
/// What single precision loses is of the size of its last digit; the few modes that a shift slows cost iterations.
constexpr std::array shifts{0.0, 1.2e-7, 1e-6};
/// In statics so many failures are enough for the rest of a run to be factored in double.
constexpr int most_failures = 2;
/// So many times the iterations then, and where the matrix is so large that a factor in double costs more, and twice the memory.
constexpr int patience = 5;

/// The type's own data (pc->data).
struct Mixed {
  std::unique_ptr<SingleFactor> single;
  KSP refinement = nullptr;
  PC exact = nullptr;         ///< factor in double, made when first needed
  bool use_exact = false;     ///< for the matrix in force
  bool pattern_read = false;  ///< by `single`
  int exact_left = 0;
  std::size_t shift = 0;  ///< number of the shift in force
  PetscInt most_iterations = 30;
  bool always_exact = false;
  bool proves = false;    ///< that matrices have no negative pivots
  bool definite = false;  ///< proved of the matrix in force
  PetscBool on_disk = PETSC_FALSE;
  int failures = 0;
  long factors = 0, patterns = 0, exact_factors = 0, solutions = 0, iterations = 0;
};

Mixed& data(PC pc) {
  return *static_cast<Mixed*>(pc->data);
}

/// The next matrices in double, too.
void remember_failure(Mixed& m) {
  m.exact_left = double_factors_after_failure;
  ++m.failures;
  if (m.proves && m.failures >= most_failures) m.always_exact = true;
}

PetscErrorCode apply_single(PC shell, Vec b, Vec x) {
  void* context = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(shell, &context));
  PetscCall(petsc::guarded([&] { static_cast<Mixed*>(context)->single->solve(b, x); }));
  PetscFunctionReturn(0);
}

/// What a residual may be relative to the right-hand side, and at all.
constexpr double largest_rtol = 1e-3, largest_atol = 1e-30;

PetscErrorCode create_refinement(PC pc) {
  Mixed& m = data(pc);
  PC shell = nullptr;
  PetscFunctionBeginUser;
  PetscCall(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), &m.refinement));
  PetscCall(KSPSetOptionsPrefix(m.refinement, reinterpret_cast<PetscObject>(pc)->prefix));
  PetscCall(KSPAppendOptionsPrefix(m.refinement, "mixed_"));
  PetscCall(KSPSetType(m.refinement, KSPCG));
  PetscCall(KSPSetNormType(m.refinement, KSP_NORM_UNPRECONDITIONED));
  PetscCall(KSPSetTolerances(m.refinement, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, m.most_iterations));
  PetscCall(KSPGetPC(m.refinement, &shell));
  PetscCall(PCSetType(shell, PCSHELL));
  PetscCall(PCShellSetContext(shell, &m));
  PetscCall(PCShellSetApply(shell, apply_single));
  PetscCall(KSPSetFromOptions(m.refinement));
  PetscReal rtol = 0.0, atol = 0.0;
  KSPNormType norm = KSP_NORM_DEFAULT;
  PetscCall(KSPGetTolerances(m.refinement, &rtol, &atol, nullptr, &m.most_iterations));
  PetscCall(KSPGetNormType(m.refinement, &norm));
  PetscCall(petsc::guarded([&] {
    if (rtol > largest_rtol || atol > largest_atol || norm == KSP_NORM_NONE)
      throw UserError(
          fmt::format("-mixed_ksp_: voile_mixed proves its solutions by their residual; -mixed_ksp_rtol of {:g} at "
                      "most, and neither -mixed_ksp_atol nor norm_type none",
                      largest_rtol));
  }));
  PetscFunctionReturn(0);
}

PetscErrorCode factor_exactly(PC pc) {
  Mixed& m = data(pc);
  PetscFunctionBeginUser;
  // Of a large problem either factor alone fills the memory.
  m.single.reset();
  m.pattern_read = false;
  if (!m.exact) {
    PetscCall(PCCreate(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), &m.exact));
    PetscCall(PCSetOptionsPrefix(m.exact, reinterpret_cast<PetscObject>(pc)->prefix));
    PetscCall(PCAppendOptionsPrefix(m.exact, "mixed_double_"));
    PetscCall(PCSetType(m.exact, PCCHOLESKY));
    PetscCall(PCFactorSetMatSolverType(m.exact, MATSOLVERMUMPS));
    PetscCall(PCSetFromOptions(m.exact));
  } else if (m.exact->failedreason || pc->flag != SAME_NONZERO_PATTERN) {
    // MUMPS's factor is of no use after an error, and PETSc would replace it by another while a new pattern is set up.
    PetscCall(PCReset(m.exact));
  }
  PetscCall(PCSetOperators(m.exact, pc->pmat, pc->pmat));
  PetscCall(PCFactorSetUpMatSolverType(m.exact));
  Mat factor = nullptr;
  PetscCall(PCFactorGetMatrix(m.exact, &factor));
  PetscCall(MatMumpsSetIcntl(factor, mumps_workspace_percent, 300));
  PetscCall(PCSetUp(m.exact));
  PetscCall(PCGetFailedReason(m.exact, &pc->failedreason));
  PetscCall(petsc::guarded([&] {
    PetscInt error = 0, size = 0;
    VOILE_PETSC(MatMumpsGetInfog(factor, mumps_error, &error));
    VOILE_PETSC(MatMumpsGetInfog(factor, mumps_error + 1, &size));
    check_mumps_room(error, size);
  }));
  m.use_exact = true;
  m.definite = false;
  ++m.exact_factors;
  PetscFunctionReturn(0);
}

PetscErrorCode factor_single(PC pc, bool& good) {
  Mixed& m = data(pc);
  PetscFunctionBeginUser;
  PetscCall(petsc::guarded([&] {
    const petsc::EventScope scope(petsc::events().factor_single);
    if (!m.single) {
      m.single = std::make_unique<SingleFactor>(PetscObjectComm(reinterpret_cast<PetscObject>(pc)));
      m.single->keep_on_disk(m.on_disk);
    }
    m.patterns += m.pattern_read ? 0 : 1;
    good = m.single->factor(pc->pmat, !m.pattern_read, shifts[m.shift]);
    m.pattern_read = good;
  }));
  PetscFunctionReturn(0);
}

PetscErrorCode set_up(PC pc) {
  Mixed& m = data(pc);
  PetscFunctionBeginUser;
  if (!m.refinement) PetscCall(create_refinement(pc));
  PetscCall(KSPSetOperators(m.refinement, pc->pmat, pc->pmat));
  if (pc->flag != SAME_NONZERO_PATTERN) m.pattern_read = false;
  ++m.factors;
  if (m.exact_left > 0 || m.always_exact) {
    m.exact_left = std::max(0, m.exact_left - 1);
    PetscCall(factor_exactly(pc));
    PetscFunctionReturn(0);
  }
  bool good = false;
  PetscCall(PCDestroy(&m.exact));
  m.use_exact = m.definite = false;
  PetscCall(factor_single(pc, good));
  if (!good) {
    remember_failure(m);
    PetscCall(factor_exactly(pc));
  }
  PetscFunctionReturn(0);
}

/// K x = b by conjugate gradients with the single factor.
PetscErrorCode refine(PC pc, Vec b, Vec x, KSPConvergedReason& reason) {
  Mixed& m = data(pc);
  PetscInt iterations = 0;
  PetscFunctionBeginUser;
  const petsc::EventScope scope(petsc::events().refine);
  PetscCall(KSPSetTolerances(m.refinement, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT,
                             (m.shift > 0 || m.single->compressed() ? patience : 1) * m.most_iterations));
  PetscCall(KSPSolve(m.refinement, b, x));
  PetscCall(KSPGetConvergedReason(m.refinement, &reason));
  PetscCall(KSPGetIterationNumber(m.refinement, &iterations));
  ++m.solutions;
  m.iterations += iterations;
  PetscFunctionReturn(0);
}

/// The same, with as much added to the diagonal as makes the factor definite; in double where nothing of that is of use, with
/// x not set then.
PetscErrorCode refine_or_factor(PC pc, Vec b, Vec x) {
  Mixed& m = data(pc);
  const std::size_t shift = m.shift;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscFunctionBeginUser;
  PetscCall(refine(pc, b, x, reason));
  while (reason == KSP_DIVERGED_INDEFINITE_PC && m.shift + 1 < shifts.size()) {
    bool good = false;
    ++m.shift;
    PetscCall(factor_single(pc, good));
    if (!good) break;
    if (m.single->negative_pivots() == 0) PetscCall(refine(pc, b, x, reason));
  }
  if (reason > 0) PetscFunctionReturn(0);
  m.shift = shift;  // none of them was of use
  PetscCall(PetscInfo(pc, "single precision is not enough (%s): factoring in double\n", KSPConvergedReasons[reason]));
  remember_failure(m);
  PetscCall(factor_exactly(pc));
  PetscFunctionReturn(0);
}

PetscErrorCode apply(PC pc, Vec b, Vec x) {
  Mixed& m = data(pc);
  PetscFunctionBeginUser;
  if (!m.use_exact) PetscCall(refine_or_factor(pc, b, x));
  if (m.use_exact && !pc->failedreason) PetscCall(PCApply(m.exact, b, x));
  PetscFunctionReturn(0);
}

/// Solves for a right side drawn at random. While no search direction meets negative curvature, all roots of the polynomial p
/// that has made of b the residual p(K M^-1) b are positive, so that |p| > 1 at a negative eigenvalue: its mode v, |v| = 1, then has
/// |v.b| <= rtol |b|, which one of n rows drawn at random has with a probability of rtol sqrt(2 n/pi).
PetscErrorCode prove_definite(PC pc) {
  Mixed& m = data(pc);
  petsc::VecHandle b, x;
  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(pc->pmat, x.out(), b.out()));
  PetscCall(VecSetRandom(b, nullptr));
  PetscCall(VecShift(b, -0.5));
  PetscCall(refine_or_factor(pc, b, x));
  m.definite = !m.use_exact;
  PetscFunctionReturn(0);
}

PetscErrorCode ask_options(PC pc, PetscOptionItems* PetscOptionsObject) {
  Mixed& m = data(pc);
  PetscFunctionBeginUser;
  PetscOptionsHeadBegin(PetscOptionsObject, "A factor in single precision, refined");
  PetscCall(PetscOptionsBool("-pc_mixed_on_disk", "Keep the factor in files (folder: MUMPS_OOC_TMPDIR)", nullptr,
                             m.on_disk, &m.on_disk, nullptr));
  PetscOptionsHeadEnd();
  PetscFunctionReturn(0);
}

PetscErrorCode reset(PC pc) {
  Mixed& m = data(pc);
  PetscFunctionBeginUser;
  m.single.reset();
  m.pattern_read = m.use_exact = false;
  PetscCall(KSPDestroy(&m.refinement));
  PetscCall(PCDestroy(&m.exact));
  PetscFunctionReturn(0);
}

PetscErrorCode destroy(PC pc) {
  PetscFunctionBeginUser;
  PetscCall(reset(pc));
  delete static_cast<Mixed*>(pc->data);
  pc->data = nullptr;
  PetscFunctionReturn(0);
}

PetscErrorCode view(PC pc, PetscViewer viewer) {
  const Mixed& m = data(pc);
  PetscFunctionBeginUser;
  PetscCall(PetscViewerASCIIPrintf(viewer, "  MUMPS in single precision, refined by conjugate gradients\n"));
  if (m.shift > 0) PetscCall(PetscViewerASCIIPrintf(viewer, "  %g of the diagonal added\n", shifts[m.shift]));
  PetscCall(PetscViewerASCIIPrintf(
      viewer,
      "  matrices %ld with %ld patterns, of them %ld in double; solutions refined %ld, with %.1f iterations each\n",
      m.factors, m.patterns, m.exact_factors, m.solutions,
      m.solutions > 0 ? static_cast<double>(m.iterations) / static_cast<double>(m.solutions) : 0.0));
  PetscFunctionReturn(0);
}

PetscErrorCode create(PC pc) {
  PetscFunctionBeginUser;
  pc->data = new Mixed;
  pc->ops->setup = set_up;
  pc->ops->apply = apply;
  pc->ops->reset = reset;
  pc->ops->destroy = destroy;
  pc->ops->view = view;
  pc->ops->setfromoptions = ask_options;
  PetscFunctionReturn(0);
}

}  // namespace

void register_mixed_pc() {
  static bool done = false;
  if (!done) VOILE_PETSC(PCRegister(mixed_pc_type, create));
  done = true;
}

void set_mixed_double(PC pc) {
  data(pc).always_exact = true;
}

void set_mixed_proves(PC pc) {
  data(pc).proves = true;
}

long mixed_negative_pivots(PC pc) {
  const Mixed& m = data(pc);
  if (m.proves && !m.use_exact && !m.definite && m.single) VOILE_PETSC(prove_definite(pc));
  if (m.definite) return 0;
  if (pc->failedreason) return -1;
  if (!m.use_exact) return m.single && m.shift == 0 ? m.single->negative_pivots() : -1;
  Mat factor = nullptr;
  PetscInt count = 0;
  VOILE_PETSC(PCFactorGetMatrix(m.exact, &factor));
  VOILE_PETSC(MatMumpsGetInfog(factor, mumps_negative_pivots, &count));
  return count;
}

long mixed_double_factors(PC pc) {
  return data(pc).exact_factors;
}

}  // namespace voile::linear

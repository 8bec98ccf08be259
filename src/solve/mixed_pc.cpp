#include "voile/solve/mixed_pc.hpp"

#include <petsc/private/pcimpl.h>

#include <algorithm>
#include <memory>

#include "mumps_single.hpp"
#include "voile/base/petsc.hpp"
#include "voile/solve/linear_solver.hpp"

namespace voile::solve {

namespace {

/// After single precision has failed, so many matrices are factored in double before it is tried again.
constexpr int double_factors_after_failure = 10;

/// The type's own data (pc->data).
struct Mixed {
  std::unique_ptr<SingleFactor> single;
  KSP refinement = nullptr;
  PC exact = nullptr;         ///< factor in double, made when first needed
  bool use_exact = false;     ///< for the matrix in force
  bool pattern_read = false;  ///< by `single`
  int exact_left = 0;
  bool always_exact = false;
  long factors = 0, patterns = 0, exact_factors = 0, solutions = 0, iterations = 0;
};

Mixed& data(PC pc) {
  return *static_cast<Mixed*>(pc->data);
}

PetscErrorCode apply_single(PC shell, Vec b, Vec x) {
  void* context = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(shell, &context));
  PetscCall(petsc::guarded([&] { static_cast<Mixed*>(context)->single->solve(b, x); }));
  PetscFunctionReturn(0);
}

PetscErrorCode create_refinement(PC pc) {
  Mixed& m = data(pc);
  PC shell = nullptr;
  PetscFunctionBeginUser;
  PetscCall(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), &m.refinement));
  PetscCall(KSPSetOptionsPrefix(m.refinement, reinterpret_cast<PetscObject>(pc)->prefix));
  PetscCall(KSPAppendOptionsPrefix(m.refinement, "mixed_"));
  PetscCall(KSPSetType(m.refinement, KSPCG));
  PetscCall(KSPSetNormType(m.refinement, KSP_NORM_UNPRECONDITIONED));
  PetscCall(KSPSetTolerances(m.refinement, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 30));
  PetscCall(KSPGetPC(m.refinement, &shell));
  PetscCall(PCSetType(shell, PCSHELL));
  PetscCall(PCShellSetContext(shell, &m));
  PetscCall(PCShellSetApply(shell, apply_single));
  PetscCall(KSPSetFromOptions(m.refinement));
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
  } else if (m.exact->failedreason) {
    PetscCall(PCReset(m.exact));  // MUMPS's factor is of no use after an error
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
    check_mumps_memory(error, size);
  }));
  m.use_exact = true;
  ++m.exact_factors;
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
  PetscCall(petsc::guarded([&] {
    const petsc::EventScope scope(petsc::events().factor_single);
    if (!m.single) m.single = std::make_unique<SingleFactor>(PetscObjectComm(reinterpret_cast<PetscObject>(pc)));
    m.patterns += m.pattern_read ? 0 : 1;
    good = m.single->factor(pc->pmat, !m.pattern_read);
    m.pattern_read = good;
  }));
  m.use_exact = false;
  if (!good) {
    m.exact_left = double_factors_after_failure;
    PetscCall(factor_exactly(pc));
  }
  PetscFunctionReturn(0);
}

PetscErrorCode apply(PC pc, Vec b, Vec x) {
  Mixed& m = data(pc);
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  PetscFunctionBeginUser;
  if (!m.use_exact) {
    const petsc::EventScope scope(petsc::events().refine);
    PetscCall(KSPSolve(m.refinement, b, x));
    PetscCall(KSPGetConvergedReason(m.refinement, &reason));
    PetscCall(KSPGetIterationNumber(m.refinement, &iterations));
    ++m.solutions;
    m.iterations += iterations;
    if (reason > 0) PetscFunctionReturn(0);
    PetscCall(PetscInfo(pc, "single precision is not enough (%s): factoring in double\n", KSPConvergedReasons[reason]));
    m.exact_left = double_factors_after_failure;
    PetscCall(factor_exactly(pc));
  }
  if (!pc->failedreason) PetscCall(PCApply(m.exact, b, x));
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

long mixed_negative_pivots(PC pc) {
  const Mixed& m = data(pc);
  if (!m.use_exact) return m.single ? m.single->negative_pivots() : -1;
  Mat factor = nullptr;
  PetscInt count = 0;
  VOILE_PETSC(PCFactorGetMatrix(m.exact, &factor));
  VOILE_PETSC(MatMumpsGetInfog(factor, mumps_negative_pivots, &count));
  return count;
}

long mixed_double_factors(PC pc) {
  return data(pc).exact_factors;
}

}  // namespace voile::solve

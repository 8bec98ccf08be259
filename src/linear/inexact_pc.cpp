#include "inexact_pc.hpp"

#include <fmt/format.h>
#include <petsc/private/pcimpl.h>

#include <algorithm>
#include <cmath>

#include "base/petsc.hpp"
#include "block_icc_pc.hpp"
#include "mixed_pc.hpp"
#include "symmetric_blocks.hpp"
#include "voile/errors.hpp"

namespace voile::linear {

namespace {

/// Residual (as in inexact_pc.hpp) of a solution as exact as can be, and the smallest bound asked for otherwise.
constexpr double exact_rtol = 1e-12, least_rtol = 1e-10;
/// Iterations that are allowed at least: small systems are solved in no time either way.
constexpr PetscInt least_longest = 30;
/// Fraction of the diagonal that the incomplete factor adds from the start: fewer iterations than without, and hardly ever a second try.
constexpr double usual_shift = 3e-3;
/// From so many vertices on the incomplete factor has a coarse level of so many aggregates: with fewer vertices it costs what it saves.
constexpr double coarse_vertices = 15000.0;
constexpr int usual_aggregates = 128;
/// After the first failure so many matrices are factored; at most so many.
constexpr int first_wait = 8, longest_wait = 512;
/// Fraction of the allowed iterations after which hopeless solutions are given up, and what is hopeless: needing this many
/// times what is allowed.
constexpr double verdict_at = 0.3, hopeless = 2.0;

/// The type's own data (pc->data).
struct Inexact {
  KSP iteration = nullptr;
  PC factor = nullptr;  ///< made when first needed
  SymmetricBlocks product;
  bool product_read = false, product_works = false;  ///< the pattern of the product, and whether it has one
  bool in_double = false, use_factor = false;
  bool may_be_indefinite = false;
  InexactCallbacks callbacks;
  InexactCounts counts;
  InexactMemory memory;
  int longest_said = 0;  ///< wait that the log already has
  double rtol = 0.0, last_rtol = 1e-4, break_even = 3.0;
  // of the solution at work
  double first_norm = 0.0;
  bool must_be_exact = false;
  PetscInt longest = 0;  ///< iterations
};

Inexact& data(PC pc) {
  return *static_cast<Inexact*>(pc->data);
}

PetscErrorCode say(const Inexact& m, const std::string& text) {
  PetscFunctionBeginUser;
  if (m.callbacks.say) PetscCall(m.callbacks.say(m.callbacks.context, text));
  PetscFunctionReturn(0);
}

/// The norm is that of -inexact_ksp_norm_type, by default sqrt(r.P^-1 r).
PetscErrorCode converged(KSP, PetscInt it, PetscReal norm, KSPConvergedReason* reason, void* context) {
  Inexact& m = *static_cast<Inexact*>(context);
  PetscFunctionBeginUser;
  *reason = KSP_CONVERGED_ITERATING;
  if (it == 0) m.first_norm = norm;
  if (!std::isfinite(norm)) {
    *reason = KSP_DIVERGED_NANORINF;
    PetscFunctionReturn(0);
  }
  const double left = m.first_norm > 0.0 ? norm / m.first_norm : 0.0;
  if (left <= m.rtol && !m.must_be_exact && m.callbacks.is_last) {
    Vec x = nullptr;
    PetscBool last = PETSC_FALSE;
    PetscCall(KSPGetSolution(m.iteration, &x));
    PetscCall(m.callbacks.is_last(m.callbacks.context, x, &last));
    m.must_be_exact = last;
  }
  const double wanted = std::max(m.must_be_exact ? std::min(m.rtol, m.last_rtol) : m.rtol, exact_rtol);
  if (left <= wanted) {
    *reason = KSP_CONVERGED_RTOL;
  } else if (it >= m.longest) {
    *reason = KSP_DIVERGED_ITS;
  } else if (it > 0 && it == static_cast<PetscInt>(verdict_at * m.longest)) {
    const double needed = left < 1.0 ? it * std::log(wanted) / std::log(left) : HUGE_VAL;
    if (needed > hopeless * m.longest) *reason = KSP_DIVERGED_ITS;
  }
  PetscFunctionReturn(0);
}

PetscErrorCode create_iteration(PC pc) {
  Inexact& m = data(pc);
  PC inner = nullptr;
  PetscInt rows = 0, given = 0;
  PetscFunctionBeginUser;
  PetscCall(MatGetSize(pc->pmat, &rows, nullptr));
  PetscCall(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), &m.iteration));
  PetscCall(KSPSetOptionsPrefix(m.iteration, reinterpret_cast<PetscObject>(pc)->prefix));
  PetscCall(KSPAppendOptionsPrefix(m.iteration, "inexact_"));
  PetscCall(KSPSetType(m.iteration, KSPCG));
  PetscCall(KSPSetNormType(m.iteration, KSP_NORM_NATURAL));
  PetscCall(KSPSetConvergenceTest(m.iteration, converged, &m, nullptr));
  const double vertices = static_cast<double>(rows) / 3.0;
  PetscCall(
      KSPSetTolerances(m.iteration, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT,
                       std::max<PetscInt>(least_longest, static_cast<PetscInt>(m.break_even * std::sqrt(vertices)))));
  PetscCall(KSPGetPC(m.iteration, &inner));
  PetscCall(petsc::guarded([] { register_block_icc_pc(); }));
  PetscCall(PCSetType(inner, block_icc_pc_type));
  set_block_icc_shift(inner, usual_shift);
  if (vertices >= coarse_vertices) set_block_icc_aggregates(inner, usual_aggregates);
  PetscCall(KSPSetFromOptions(m.iteration));
  KSPNormType norm = KSP_NORM_DEFAULT;
  PetscCall(KSPGetNormType(m.iteration, &norm));
  PetscCall(petsc::guarded([&] {
    if (norm == KSP_NORM_NONE)
      throw UserError("-inexact_ksp_norm_type none: such an iteration does not know when to end");
  }));
  PetscCall(KSPGetTolerances(m.iteration, nullptr, nullptr, nullptr, &given));
  m.longest = given;
  PetscFunctionReturn(0);
}

PetscErrorCode factor(PC pc) {
  Inexact& m = data(pc);
  PetscFunctionBeginUser;
  if (!m.factor) {
    PetscCall(PCCreate(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), &m.factor));
    PetscCall(PCSetOptionsPrefix(m.factor, reinterpret_cast<PetscObject>(pc)->prefix));
    PetscCall(PCAppendOptionsPrefix(m.factor, "inexact_factor_"));
    PetscCall(petsc::guarded([] { register_mixed_pc(); }));
    PetscCall(PCSetType(m.factor, mixed_pc_type));
    if (m.in_double) set_mixed_double(m.factor);
    PetscCall(PCSetFromOptions(m.factor));
  }
  PetscCall(PCSetOperators(m.factor, pc->pmat, pc->pmat));
  PetscCall(PCSetUp(m.factor));
  PetscCall(PCGetFailedReason(m.factor, &pc->failedreason));
  m.use_factor = true;
  ++m.counts.factors;
  PetscFunctionReturn(0);
}

/// From now on factors, for a while.
PetscErrorCode wait(PC pc, const char* why) {
  Inexact& m = data(pc);
  PetscFunctionBeginUser;
  m.memory.wait = std::clamp(2 * m.memory.wait, first_wait, longest_wait);
  m.memory.factors_left = m.memory.wait;
  PetscCall(PetscInfo(pc, "conjugate gradients: %s; the next %d matrices are factored\n", why, m.memory.wait));
  // A motion in contact goes to and fro: only a wait that is longer than all before is news.
  if (m.memory.wait > m.longest_said)
    PetscCall(
        say(m, fmt::format("conjugate gradients {}: this tangent and the next {} are factored, then they are tried "
                           "again (-info shows every change)",
                           why, m.memory.wait)));
  m.longest_said = std::max(m.longest_said, m.memory.wait);
  PetscFunctionReturn(0);
}

/// The incomplete factor, or the other if there is none.
PetscErrorCode prepare_iteration(PC pc) {
  Inexact& m = data(pc);
  PC inner = nullptr;
  PCFailedReason failed = PC_NOERROR;
  PetscFunctionBeginUser;
  PetscCall(petsc::guarded([&] {
    m.product_works = (m.product_works || !m.product_read) && m.product.take(pc->pmat, !m.product_read);
    m.product_read = true;
  }));
  PetscCall(KSPSetOperators(m.iteration, m.product_works ? m.product.mat() : pc->pmat, pc->pmat));
  PetscBool known = PETSC_FALSE;
  PetscCall(KSPGetPC(m.iteration, &inner));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(inner), block_icc_pc_type, &known));
  // Where it takes more than the usual shift, an indefinite tangent is the likely reason.
  if (known) allow_block_icc_shifts(inner, !m.may_be_indefinite);
  PetscCall(KSPSetUp(m.iteration));
  PetscCall(PCGetFailedReason(inner, &failed));
  if (known) m.counts.shifted = block_icc_shifted(inner);
  m.use_factor = false;
  pc->failedreason = PC_NOERROR;
  if (!failed) PetscFunctionReturn(0);
  if (m.may_be_indefinite) {
    ++m.counts.negative_curvature;
    pc->failedreason = failed;
    PetscFunctionReturn(0);
  }
  PetscCall(wait(pc, "find no incomplete factor"));
  PetscCall(factor(pc));
  PetscFunctionReturn(0);
}

PetscErrorCode set_up(PC pc) {
  Inexact& m = data(pc);
  PetscFunctionBeginUser;
  if (!m.iteration) PetscCall(create_iteration(pc));
  if (!pc->setupcalled || pc->flag != SAME_NONZERO_PATTERN) m.product_read = false;
  ++m.counts.matrices;
  if (m.memory.factors_left > 0) {
    if (--m.memory.factors_left == 0) PetscCall(PetscInfo(pc, "conjugate gradients are tried again\n"));
    PetscCall(factor(pc));
  } else {
    PetscCall(prepare_iteration(pc));
  }
  PetscFunctionReturn(0);
}

/// True if the iteration has found x. Negative curvature shows itself by a search direction, or, in the first one, by a
/// solution that leads uphill.
PetscErrorCode iterate(PC pc, Vec b, Vec x, KSPConvergedReason* reason) {
  Inexact& m = data(pc);
  PetscInt iterations = 0;
  PetscReal slope = 0.0;
  PetscFunctionBeginUser;
  const petsc::EventScope scope(petsc::events().iterate);
  m.must_be_exact = false;
  PetscCall(KSPSolve(m.iteration, b, x));
  PetscCall(KSPGetConvergedReason(m.iteration, reason));
  PetscCall(KSPGetIterationNumber(m.iteration, &iterations));
  m.counts.iterations += iterations;
  if (*reason > 0) {
    PetscCall(VecDot(b, x, &slope));
    if (slope < 0.0) *reason = KSP_DIVERGED_INDEFINITE_MAT;
  }
  if (*reason == KSP_DIVERGED_INDEFINITE_MAT) ++m.counts.negative_curvature;
  if (*reason > 0) {
    ++m.counts.solutions;
    m.memory.wait = 0;
  }
  PetscFunctionReturn(0);
}

/// Another matrix, instead of one with negative curvature.
PetscErrorCode make_positive(const Inexact& m, PetscBool* changed) {
  PetscFunctionBeginUser;
  *changed = PETSC_FALSE;
  if (m.callbacks.make_positive) PetscCall(m.callbacks.make_positive(m.callbacks.context, changed));
  PetscFunctionReturn(0);
}

PetscErrorCode apply(PC pc, Vec b, Vec x) {
  Inexact& m = data(pc);
  KSPConvergedReason reason = KSP_DIVERGED_INDEFINITE_MAT;
  PetscBool changed = PETSC_FALSE;
  PetscFunctionBeginUser;
  if (!m.use_factor) {
    PetscCall(iterate(pc, b, x, &reason));
    if (reason == KSP_DIVERGED_INDEFINITE_MAT) {
      PetscCall(make_positive(m, &changed));
      if (changed) {
        m.may_be_indefinite = false;
        PetscCall(prepare_iteration(pc));
        if (!m.use_factor) PetscCall(iterate(pc, b, x, &reason));
      }
    }
    if (reason > 0) PetscFunctionReturn(0);
  }
  if (!m.use_factor) {
    PetscCall(wait(pc, reason == KSP_DIVERGED_ITS ? fmt::format("need more than {} iterations", m.longest).c_str()
                                                  : "meet negative curvature"));
    PetscCall(factor(pc));
    if (!pc->failedreason && mixed_negative_pivots(m.factor) > 0) {
      PetscCall(make_positive(m, &changed));
      if (changed) PetscCall(factor(pc));
    }
  }
  if (!pc->failedreason) PetscCall(PCApply(m.factor, b, x));
  PetscFunctionReturn(0);
}

PetscErrorCode ask_options(PC pc, PetscOptionItems* PetscOptionsObject) {
  Inexact& m = data(pc);
  PetscFunctionBeginUser;
  PetscOptionsHeadBegin(PetscOptionsObject, "Conjugate gradients as exact as Newton's method needs, or a factor");
  PetscCall(PetscOptionsReal("-pc_inexact_last_rtol",
                             "Relative tolerance of the solution that an iteration may end with", nullptr, m.last_rtol,
                             &m.last_rtol, nullptr));
  PetscCall(PetscOptionsReal("-pc_inexact_break_even", "Iterations worth a factor, per square root of vertices",
                             nullptr, m.break_even, &m.break_even, nullptr));
  PetscOptionsHeadEnd();
  PetscFunctionReturn(0);
}

PetscErrorCode reset(PC pc) {
  Inexact& m = data(pc);
  PetscFunctionBeginUser;
  PetscCall(KSPDestroy(&m.iteration));
  PetscCall(PCDestroy(&m.factor));
  m.product = SymmetricBlocks{};
  m.use_factor = m.product_read = m.product_works = false;
  PetscFunctionReturn(0);
}

PetscErrorCode destroy(PC pc) {
  PetscFunctionBeginUser;
  PetscCall(reset(pc));
  delete static_cast<Inexact*>(pc->data);
  pc->data = nullptr;
  PetscFunctionReturn(0);
}

PetscErrorCode view(PC pc, PetscViewer viewer) {
  const Inexact& m = data(pc);
  const InexactCounts& c = m.counts;
  PetscFunctionBeginUser;
  PetscCall(PetscViewerASCIIPrintf(viewer, "  matrices %ld, of them %ld factored; %ld solutions by iteration\n",
                                   c.matrices, c.factors, c.solutions));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "  iterations %ld, at most %d each; incomplete factors with a shift %ld, negative "
                                   "curvature %ld\n",
                                   c.iterations, static_cast<int>(m.longest), c.shifted, c.negative_curvature));
  if (m.iteration) PetscCall(KSPView(m.iteration, viewer));
  PetscFunctionReturn(0);
}

PetscErrorCode create(PC pc) {
  PetscFunctionBeginUser;
  pc->data = new Inexact;
  pc->ops->setup = set_up;
  pc->ops->apply = apply;
  pc->ops->setfromoptions = ask_options;
  pc->ops->reset = reset;
  pc->ops->destroy = destroy;
  pc->ops->view = view;
  PetscFunctionReturn(0);
}

}  // namespace

void register_inexact_pc() {
  static bool done = false;
  if (!done) VOILE_PETSC(PCRegister(inexact_pc_type, create));
  done = true;
}

void set_inexact_callbacks(PC pc, const InexactCallbacks& callbacks) {
  data(pc).callbacks = callbacks;
}

void expect_indefinite(PC pc, bool possible) {
  data(pc).may_be_indefinite = possible;
}

void set_inexact_tolerance(PC pc, double relative) {
  data(pc).rtol = relative > 0.0 ? std::max(relative, least_rtol) : 0.0;
}

void set_inexact_double(PC pc) {
  data(pc).in_double = true;
  if (data(pc).factor) set_mixed_double(data(pc).factor);
}

const InexactCounts& inexact_counts(PC pc) {
  return data(pc).counts;
}

InexactMemory inexact_memory(PC pc) {
  return data(pc).memory;
}

void set_inexact_memory(PC pc, const InexactMemory& memory) {
  data(pc).memory = memory;
}

long inexact_negative_pivots(PC pc) {
  const Inexact& m = data(pc);
  return m.use_factor ? mixed_negative_pivots(m.factor) : -1;
}

}  // namespace voile::linear

#include "voile/solve/newton.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"

namespace voile::solve {

namespace {

constexpr int mumps_workspace_percent = 14, mumps_error = 1, mumps_negative_pivots = 12;  ///< ICNTL, INFOG numbers
constexpr int workspace_retries = 5;
constexpr int continuation_iterations = 300;
/// Relative residual below which continuation uses the exact tangent, and below which it hands over to Newton.
constexpr double exact_tangent_below = 1e-2, handover_below = 1e-4;

/// Positions are known to eps |X|, membrane forces per vertex to eps |X| times the membrane stiffness.
double round_off_of(const system::Model& model) {
  double stiffness = 0.0, distance = model.mesh().extent();
  for (const energy::Material& m : model.sheet().materials()) stiffness = std::max(stiffness, m.membrane.norm());
  for (const Vec3& x : model.mesh().positions()) distance = std::max(distance, x.norm());
  return std::numeric_limits<double>::epsilon() * stiffness * distance *
         std::sqrt(static_cast<double>(model.unknowns()));
}

}  // namespace

struct Newton::Impl {
  system::Model& model;
  petsc::SnesHandle snes;
  petsc::VecHandle residual, start, previous, increment, trial;
  bool has_previous = false, mumps = false;
  int factorisations = 0;
  double step_norm = 0.0, last_work = 0.0, last_residual = 0.0;
  double round_off;            ///< norm of the residual that the round-off of positions alone can leave [N]
  std::string failure;         ///< text of an exception in a callback
  std::string linear_failure;  ///< what the linear solver said last

  explicit Impl(system::Model& m) : model(m), round_off(round_off_of(m)) {
    for (petsc::VecHandle* v : {&residual, &start, &previous, &increment, &trial}) *v = m.create_vector();
  }

  void create();
  void prepare_mumps();
  [[nodiscard]] Mat factor() const;
  [[nodiscard]] long negative_pivots() const;
  /// After a failed solve: makes the factor usable again. True if trying again with more workspace may help.
  [[nodiscard]] bool repair_factor(int attempt);
  [[nodiscard]] NewtonResult solve_once(Vec a);
  [[nodiscard]] bool solve_linear(Vec rhs, Vec dx);
  /// Shift at which the residual moves the fastest vertex by about one cell.
  [[nodiscard]] double first_shift();
  [[nodiscard]] double backtrack(Vec a, double energy, double slope, double& accepted_energy);
  [[nodiscard]] SNESConvergedReason judge(PetscInt iteration, double increment_norm, double residual_norm);

  static PetscErrorCode form_function(SNES, Vec a, Vec r, void* self);
  static PetscErrorCode form_jacobian(SNES, Vec a, Mat, Mat, void* self);
  static PetscErrorCode converged(SNES, PetscInt it, PetscReal xnorm, PetscReal snorm, PetscReal fnorm,
                                  SNESConvergedReason* reason, void* self);
  static PetscErrorCode before_linear_solve(KSP, Vec rhs, Vec x, void* self);
  static PetscErrorCode after_linear_solve(KSP, Vec rhs, Vec x, void* self);
};

// ---- callbacks: an exception must not cross PETSc's C frames -------------------------------------------------------

namespace {

/// Runs `work`; an exception becomes a PETSc error and its text is kept for the caller.
template <class Work>
PetscErrorCode guarded(std::string& failure, Work&& work) {
  try {
    work();
  } catch (const std::exception& e) {
    failure = e.what();
    return PETSC_ERR_LIB;
  }
  return 0;
}

}  // namespace

PetscErrorCode Newton::Impl::form_function(SNES, Vec a, Vec r, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return guarded(n.failure, [&] { n.model.residual(a, r); });
}

PetscErrorCode Newton::Impl::form_jacobian(SNES, Vec a, Mat, Mat, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return guarded(n.failure, [&] {
    n.model.assemble_tangent(a, n.has_previous ? static_cast<Vec>(n.previous) : nullptr,
                             energy::Tangent::linearised_stress, 0.0);
    VOILE_PETSC(VecCopy(a, n.previous));
    n.has_previous = true;
    ++n.factorisations;
  });
}

PetscErrorCode Newton::Impl::converged(SNES, PetscInt it, PetscReal, PetscReal snorm, PetscReal fnorm,
                                       SNESConvergedReason* reason, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return guarded(n.failure, [&] { *reason = n.judge(it, it > 0 ? snorm : -1.0, fnorm); });
}

PetscErrorCode Newton::Impl::before_linear_solve(KSP, Vec rhs, Vec, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return guarded(n.failure, [&] {
    if (n.model.fixed_coupling()) VOILE_PETSC(VecAXPY(rhs, -1.0, n.model.fixed_coupling()));
  });
}

PetscErrorCode Newton::Impl::after_linear_solve(KSP, Vec rhs, Vec x, void* self) {
  auto& n = *static_cast<Impl*>(self);
  return guarded(n.failure, [&] {
    if (n.model.fixed_coupling()) VOILE_PETSC(VecAXPY(rhs, 1.0, n.model.fixed_coupling()));
    VOILE_PETSC(VecDot(rhs, x, &n.last_work));
  });
}

// ---- set-up --------------------------------------------------------------------------------------------------------

void Newton::Impl::create() {
  VOILE_PETSC(SNESCreate(model.comm(), snes.out()));
  VOILE_PETSC(SNESSetType(snes, SNESNEWTONLS));
  VOILE_PETSC(SNESSetFunction(snes, residual, form_function, this));
  VOILE_PETSC(SNESSetJacobian(snes, model.tangent_matrix(), model.tangent_matrix(), form_jacobian, this));
  VOILE_PETSC(SNESSetConvergenceTest(snes, converged, this, nullptr));
  VOILE_PETSC(SNESSetTolerances(snes, PETSC_DEFAULT, 1e-8, 1e-6, 20, PETSC_MAX_INT));
  SNESLineSearch line_search = nullptr;
  VOILE_PETSC(SNESGetLineSearch(snes, &line_search));
  VOILE_PETSC(SNESLineSearchSetType(line_search, SNESLINESEARCHBASIC));
  KSP ksp = nullptr;
  PC pc = nullptr;
  VOILE_PETSC(SNESGetKSP(snes, &ksp));
  VOILE_PETSC(KSPSetType(ksp, KSPPREONLY));
  VOILE_PETSC(KSPSetPreSolve(ksp, before_linear_solve, this));
  VOILE_PETSC(KSPSetPostSolve(ksp, after_linear_solve, this));
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  VOILE_PETSC(PCSetType(pc, model.symmetric() ? PCCHOLESKY : PCLU));
  VOILE_PETSC(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  VOILE_PETSC(SNESSetFromOptions(snes));
  prepare_mumps();
}

void Newton::Impl::prepare_mumps() {
  KSP ksp = nullptr;
  PC pc = nullptr;
  VOILE_PETSC(SNESGetKSP(snes, &ksp));
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  PetscBool cholesky = PETSC_FALSE, lu = PETSC_FALSE, is_mumps = PETSC_FALSE, given = PETSC_FALSE;
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &cholesky));
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCLU, &lu));
  if (!cholesky && !lu) return;
  MatSolverType type = nullptr;
  VOILE_PETSC(PCFactorGetMatSolverType(pc, &type));
  VOILE_PETSC(PetscStrcmp(type, MATSOLVERMUMPS, &is_mumps));
  mumps = is_mumps;
  if (!mumps) return;
  VOILE_PETSC(KSPSetOperators(ksp, model.tangent_matrix(), model.tangent_matrix()));
  VOILE_PETSC(PCFactorSetUpMatSolverType(pc));
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-mat_mumps_icntl_14", &given));
  // MUMPS's own 20 % fails at random in parallel.
  if (!given) VOILE_PETSC(MatMumpsSetIcntl(factor(), mumps_workspace_percent, 100));
}

Mat Newton::Impl::factor() const {
  KSP ksp = nullptr;
  PC pc = nullptr;
  Mat f = nullptr;
  VOILE_PETSC(SNESGetKSP(snes, &ksp));
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  VOILE_PETSC(PCFactorGetMatrix(pc, &f));
  return f;
}

long Newton::Impl::negative_pivots() const {
  if (!mumps || !model.symmetric() || factorisations == 0) return -1;
  PetscInt count = 0;
  VOILE_PETSC(MatMumpsGetInfog(factor(), mumps_negative_pivots, &count));
  return count;
}

bool Newton::Impl::repair_factor(int attempt) {
  if (!mumps || factorisations == 0) return false;
  PetscInt error = 0, percent = 0;
  VOILE_PETSC(MatMumpsGetInfog(factor(), mumps_error, &error));
  if (error >= 0) return false;
  // PETSc refuses to factor again after an error of MUMPS, without a word: only a new factor object helps.
  VOILE_PETSC(MatMumpsGetIcntl(factor(), mumps_workspace_percent, &percent));
  const bool lacks_workspace = error == -8 || error == -9;
  if (lacks_workspace) percent = std::max<PetscInt>(100, 2 * percent);
  // The symbolic factorisation reads the options again: the user's value, found too small, must not come back.
  PetscBool given = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-mat_mumps_icntl_14", &given));
  if (given) VOILE_PETSC(PetscOptionsSetValue(nullptr, "-mat_mumps_icntl_14", fmt::format("{}", percent).c_str()));
  KSP ksp = nullptr;
  PC pc = nullptr;
  VOILE_PETSC(SNESGetKSP(snes, &ksp));
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  VOILE_PETSC(PCReset(pc));
  VOILE_PETSC(KSPSetOperators(ksp, model.tangent_matrix(), model.tangent_matrix()));
  VOILE_PETSC(PCFactorSetUpMatSolverType(pc));
  VOILE_PETSC(MatMumpsSetIcntl(factor(), mumps_workspace_percent, percent));
  linear_failure = fmt::format("MUMPS error {}", error);
  return lacks_workspace && attempt < workspace_retries;
}

// ---- Newton --------------------------------------------------------------------------------------------------------

SNESConvergedReason Newton::Impl::judge(PetscInt iteration, double increment_norm, double residual_norm) {
  PetscReal atol = 0.0, rtol = 0.0, stol = 0.0;
  PetscInt max_iterations = 0;
  VOILE_PETSC(SNESGetTolerances(snes, &atol, &rtol, &stol, &max_iterations, nullptr));
  if (!std::isfinite(residual_norm)) return SNES_DIVERGED_FNORM_NAN;
  const double force = model.force_scale(), before = std::exchange(last_residual, residual_norm);
  const bool small_residual = residual_norm <= std::max<double>(atol, rtol * force);
  if (increment_norm < 0.0) {
    // Nothing to do only if the state is in equilibrium to more than the tolerance.
    if (residual_norm <= std::max<double>(atol, 1e-3 * rtol * force)) return SNES_CONVERGED_FNORM_ABS;
  } else {
    Vec a = nullptr;
    VOILE_PETSC(SNESGetSolution(snes, &a));
    VOILE_PETSC(VecWAXPY(trial, -1.0, start, a));
    VOILE_PETSC(VecNorm(trial, NORM_2, &step_norm));
    if (increment_norm > 20.0 * model.mesh().extent() * std::sqrt(static_cast<double>(model.unknowns())))
      return SNES_DIVERGED_DTOL;
    if (small_residual && increment_norm <= stol * step_norm) return SNES_CONVERGED_FNORM_RELATIVE;
    if (increment_norm <= 1e-3 * stol * step_norm && std::abs(last_work) <= 1e-3 * rtol * force * step_norm)
      return SNES_CONVERGED_SNORM_RELATIVE;
    // Round-off that another iteration cannot lower: forces far below the sheet's stiffness, or a start in equilibrium.
    if (residual_norm <= round_off && residual_norm >= 0.1 * before) return SNES_CONVERGED_SNORM_RELATIVE;
  }
  return iteration >= max_iterations ? SNES_DIVERGED_MAX_IT : SNES_CONVERGED_ITERATING;
}

NewtonResult Newton::Impl::solve_once(Vec a) {
  has_previous = false;
  failure.clear();
  const int before = factorisations;
  VOILE_PETSC(VecCopy(a, start));
  const PetscErrorCode code = SNESSolve(snes, nullptr, a);
  if (!failure.empty()) throw InternalError(failure);
  petsc::check(code, "SNESSolve");
  NewtonResult result;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  PetscReal norm = 0.0;
  const char* text = nullptr;
  VOILE_PETSC(SNESGetConvergedReason(snes, &reason));
  VOILE_PETSC(SNESGetIterationNumber(snes, &iterations));
  VOILE_PETSC(SNESGetFunctionNorm(snes, &norm));
  VOILE_PETSC(SNESGetConvergedReasonString(snes, &text));
  result.converged = reason > 0;
  result.iterations = iterations;
  result.factorisations = factorisations - before;
  result.residual = model.force_scale() > 0.0 ? norm / model.force_scale() : norm;
  result.negative_pivots = negative_pivots();
  result.reason = text;
  return result;
}

NewtonResult Newton::step(Vec a) {
  petsc::VecHandle origin = impl_->model.create_vector();
  VOILE_PETSC(VecCopy(a, origin));
  int spent = 0;
  for (int attempt = 0;; ++attempt) {
    NewtonResult result = impl_->solve_once(a);
    result.factorisations += spent;
    if (result.converged) return result;
    const bool again = impl_->repair_factor(attempt);
    if (!impl_->linear_failure.empty()) result.reason += " (" + std::exchange(impl_->linear_failure, {}) + ")";
    if (!again) return result;
    spent = result.factorisations;
    VOILE_PETSC(VecCopy(origin, a));
  }
}

// ---- pseudo-transient continuation ---------------------------------------------------------------------------------

bool Newton::Impl::solve_linear(Vec rhs, Vec dx) {
  KSP ksp = nullptr;
  VOILE_PETSC(SNESGetKSP(snes, &ksp));
  for (int attempt = 0;; ++attempt) {
    VOILE_PETSC(KSPSetOperators(ksp, model.tangent_matrix(), model.tangent_matrix()));
    VOILE_PETSC(KSPSolve(ksp, rhs, dx));
    ++factorisations;
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    VOILE_PETSC(KSPGetConvergedReason(ksp, &reason));
    if (reason > 0) return true;
    if (!repair_factor(attempt)) return false;
  }
}

double Newton::Impl::backtrack(Vec a, double energy, double slope, double& accepted_energy) {
  for (double length = 1.0; length > 1e-4; length *= 0.5) {
    VOILE_PETSC(VecWAXPY(trial, -length, increment, a));
    accepted_energy = model.energy(trial);
    const double round_off = 1e-13 * std::abs(energy);
    if (std::isfinite(accepted_energy) && accepted_energy <= energy - 1e-4 * length * slope + round_off) return length;
  }
  return 0.0;
}

double Newton::Impl::first_shift() {
  const double cell = std::sqrt(model.total_area() / model.mesh().triangle_count());
  double acceleration = 0.0;
  VOILE_PETSC(VecPointwiseDivide(trial, residual, model.mass()));
  VOILE_PETSC(VecNorm(trial, NORM_INFINITY, &acceleration));
  return std::max(acceleration / cell, 1e-30);
}

NewtonResult Newton::continuation(Vec a) {
  Impl& n = *impl_;
  system::Model& model = n.model;
  NewtonResult result;
  const int before = n.factorisations;
  const bool potential = model.symmetric();
  double shift = -1.0, energy = 0.0;
  double handover = handover_below, refused = std::numeric_limits<double>::infinity();
  int linear_failures = 0;
  for (result.iterations = 0; result.iterations < continuation_iterations; ++result.iterations) {
    double norm = 0.0;
    model.residual(a, n.residual);
    VOILE_PETSC(VecNorm(n.residual, NORM_2, &norm));
    VOILE_PETSC(SNESMonitor(n.snes, result.iterations, norm));
    if (!std::isfinite(norm)) break;
    result.residual = model.force_scale() > 0.0 ? norm / model.force_scale() : norm;
    if (shift < 0.0) {
      shift = n.first_shift();
      energy = model.energy(a);
    }
    if (result.residual < handover) {
      petsc::VecHandle kept = model.create_vector();
      VOILE_PETSC(VecCopy(a, kept));
      NewtonResult polished = step(a);
      polished.iterations += result.iterations;
      polished.factorisations = n.factorisations - before;
      if (polished.converged) return polished;
      VOILE_PETSC(VecCopy(kept, a));
      model.residual(a, n.residual);
      handover = 0.1 * result.residual;
      refused = result.residual;
    }
    const bool exact = result.residual < exact_tangent_below;
    model.assemble_tangent(a, nullptr, exact ? energy::Tangent::exact : energy::Tangent::positive, shift);
    if (!n.solve_linear(n.residual, n.increment)) {
      shift *= 8.0;
      if (++linear_failures < 10) continue;
      result.reason = "the linear solver failed: " + n.linear_failure;
      break;
    }
    if (exact && n.negative_pivots() > 0) {  // on a ridge of the energy: more shift makes the step a descent
      shift *= 4.0;
      continue;
    }
    double slope = 0.0, length = 1.0, new_energy = 0.0;
    VOILE_PETSC(VecDot(n.residual, n.increment, &slope));
    // Prescribed motion does work that the energy balance does not see: the first step then moves the supports in full.
    const bool moving = model.fixed_coupling() != nullptr;
    if (potential && !moving) length = n.backtrack(a, energy, slope, new_energy);
    if (length == 0.0) {
      shift *= 8.0;
      // A decrease below the energy's round-off cannot be seen: Newton, who looks at forces, is to try from here.
      if (exact && slope <= 1e-8 * std::abs(energy) && result.residual < 0.5 * refused)
        handover = 2.0 * result.residual;
      continue;
    }
    VOILE_PETSC(VecAXPY(a, -length, n.increment));
    energy = potential && !moving ? new_energy : model.energy(a);
    shift *= length == 1.0 ? 0.5 : 2.0;
  }
  result.factorisations = n.factorisations - before;
  result.negative_pivots = n.negative_pivots();
  if (result.reason.empty()) result.reason = "continuation did not settle";
  return result;
}

Newton::Newton(system::Model& model) : impl_(std::make_unique<Impl>(model)) {
  impl_->create();
}
Newton::~Newton() = default;
SNES Newton::snes() const {
  return impl_->snes;
}

}  // namespace voile::solve

#include "eigen.hpp"

#include <slepceps.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string_view>

#include "base/interrupt.hpp"
#include "base/mpi.hpp"
#include "eigen_options.hpp"
#include "linear/inertia.hpp"
#include "linear/linear_solver.hpp"
#include "linear/low_rank_solution.hpp"
#include "load_stiffness.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

using system::Mass;

namespace {

using EpsHandle = petsc::Handle<EPS, EPSDestroy>;

/// MUMPS as the direct solver of the spectral transformation, with the workspace that parallel runs need.
void use_mumps(EPS eps, bool symmetric) {
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  VOILE_PETSC(EPSGetST(eps, &st));
  VOILE_PETSC(STSetMatStructure(st, SUBSET_NONZERO_PATTERN));
  VOILE_PETSC(STGetKSP(st, &ksp));
  VOILE_PETSC(KSPSetType(ksp, KSPPREONLY));
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  VOILE_PETSC(PCSetType(pc, symmetric ? PCCHOLESKY : PCLU));
  VOILE_PETSC(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  PetscBool given = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-st_mat_mumps_icntl_14", &given));
  if (!given) VOILE_PETSC(PetscOptionsSetValue(nullptr, "-st_mat_mumps_icntl_14", "100"));
  // Without the root that ScaLAPACK factors, negative pivots are counted.
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-st_mat_mumps_icntl_13", &given));
  if (!given) VOILE_PETSC(PetscOptionsSetValue(nullptr, "-st_mat_mumps_icntl_13", "1"));
}

/// Diagonal matrix of the lumped mass, zero where the displacement is fixed.
petsc::MatHandle lumped_mass(const system::Model& model) {
  petsc::VecHandle mass = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(model.potential().constant().mass(), mass));
  model.dofs().clear_fixed(mass);
  petsc::MatHandle m;
  PetscInt rows = 0, first = 0;
  VOILE_PETSC(VecGetLocalSize(mass, &rows));
  VOILE_PETSC(VecGetOwnershipRange(mass, &first, nullptr));
  VOILE_PETSC(
      MatCreateAIJ(model.dofs().comm(), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, 1, nullptr, 0, nullptr, m.out()));
  {
    const petsc::ReadArray values(mass);
    for (PetscInt i = 0; i < rows; ++i) VOILE_PETSC(MatSetValue(m, first + i, first + i, values[i], INSERT_VALUES));
  }
  VOILE_PETSC(MatAssemblyBegin(m, MAT_FINAL_ASSEMBLY));
  VOILE_PETSC(MatAssemblyEnd(m, MAT_FINAL_ASSEMBLY));
  return m;
}

/// The largest displacement becomes 1, its largest component positive.
void normalise(const system::Model& model, Vec shape) {
  const std::vector<double> u = model.dofs().gather_change(shape);
  Vec3 largest = Vec3::Zero();
  for (std::size_t i = 0; i + 2 < u.size(); i += 3) {
    const Vec3 here(u[i], u[i + 1], u[i + 2]);
    if (here.norm() > largest.norm() * (1.0 + 1e-9)) largest = here;
  }
  Eigen::Index axis = 0;
  (void)largest.cwiseAbs().maxCoeff(&axis);
  std::vector<double> scale{std::copysign(largest.norm(), largest[axis])};
  mpi::broadcast(model.dofs().comm(), scale);
  if (scale[0] != 0.0) VOILE_PETSC(VecScale(shape, 1.0 / scale[0]));
}

/// SLEPc's own test, and the end of the iteration where a signal asks for it.
PetscErrorCode stop_test(EPS eps, PetscInt its, PetscInt most, PetscInt converged, PetscInt wanted,
                         EPSConvergedReason* reason, void*) {
  PetscFunctionBeginUser;
  PetscCall(EPSStoppingBasic(eps, its, most, converged, wanted, reason, nullptr));
  if (SignalScope::stop_asked(PetscObjectComm(reinterpret_cast<PetscObject>(eps)))) *reason = EPS_CONVERGED_USER;
  PetscFunctionReturn(0);
}

/// |K x - theta M x| / (|K x| + |theta| |M x|) with what gases add to K, which SLEPc does not know.
double residual_with_gas(const system::Model& model, Mat mass, const Mode& mode) {
  petsc::VecHandle k = model.dofs().create_vector(), m = model.dofs().create_vector();
  double size_k = 0.0, size_m = 0.0, left = 0.0;
  model.tangent().multiply(mode.shape, k);
  VOILE_PETSC(MatMult(mass, mode.shape, m));
  VOILE_PETSC(VecNorm(k, NORM_2, &size_k));
  VOILE_PETSC(VecNorm(m, NORM_2, &size_m));
  VOILE_PETSC(VecAXPY(k, -mode.eigenvalue, m));
  VOILE_PETSC(VecNorm(k, NORM_2, &left));
  return left / (size_k + std::abs(mode.eigenvalue) * size_m);
}

/// Gases: the systems of the spectral transformation are solved with what they add.
struct GasSolution {
  const system::Model& model;
  linear::LowRankSolution solution;

  static PetscErrorCode complete(KSP ksp, Vec, Vec x, void* self) {
    auto& s = *static_cast<GasSolution*>(self);
    return petsc::guarded([&] {
      PC pc = nullptr;
      VOILE_PETSC(KSPGetPC(ksp, &pc));
      s.solution.prepare(pc, s.model.tangent().change());
      s.solution.correct(s.model.tangent().change(), x);
    });
  }
};

/// Backward error beyond which a pair that SLEPc calls converged is none.
constexpr double most_residual = 1e-6;

/// Solves and collects the pairs in the order of SLEPc.
std::vector<Mode> solve(EPS eps, const system::Model& model, int count) {
  VOILE_PETSC(EPSSetStoppingTestFunction(eps, stop_test, nullptr, nullptr));
  VOILE_PETSC(EPSSolve(eps));
  PetscInt converged = 0;
  VOILE_PETSC(EPSGetConverged(eps, &converged));
  std::vector<Mode> modes;
  for (PetscInt i = 0; i < std::min<PetscInt>(converged, count); ++i) {
    Mode mode;
    mode.shape = model.dofs().create_vector();
    VOILE_PETSC(EPSGetEigenpair(eps, i, &mode.eigenvalue, &mode.imaginary, mode.shape, nullptr));
    VOILE_PETSC(EPSComputeError(eps, i, EPS_ERROR_BACKWARD, &mode.residual));
    // Of a solver that options have made too weak. What gases add is not in these matrices.
    if (model.tangent().change().empty() && !(mode.residual <= most_residual)) continue;
    model.dofs().clear_fixed(mode.shape);
    normalise(model, mode.shape);
    modes.push_back(std::move(mode));
  }
  return modes;
}

/// Common part of both problems: A x = theta B x.
EpsHandle create(const system::Model& model, Mat a, Mat b, int count) {
  EpsHandle eps;
  VOILE_PETSC(EPSCreate(model.dofs().comm(), eps.out()));
  VOILE_PETSC(EPSSetOperators(eps, a, b));
  VOILE_PETSC(EPSSetProblemType(eps, model.conditions().symmetric() ? EPS_GHEP : EPS_GNHEP));
  VOILE_PETSC(EPSSetDimensions(eps, count, PETSC_DEFAULT, PETSC_DEFAULT));
  VOILE_PETSC(EPSSetTolerances(eps, 1e-9, 1000));
  use_mumps(eps, model.conditions().symmetric());
  return eps;
}

int wanted(EPS eps) {
  PetscInt count = 0;
  VOILE_PETSC(EPSGetDimensions(eps, &count, nullptr, nullptr));
  return static_cast<int>(count);
}

/// Eigenvalues closer together than this fraction are one.
constexpr double apart = 1e-6;

/// By which a target below zero falls until no eigenvalue is below it.
constexpr double target_factor = 2.0;
constexpr int most_targets = 100;

/// How many eigenvalues are below the target of a spectral transformation that has factored there; 0 if that is not known.
long found_below(EPS eps) {
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  Mat factor = nullptr;
  PetscBool inverts = PETSC_FALSE, symmetric = PETSC_FALSE;
  VOILE_PETSC(EPSGetST(eps, &st));
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(st), STSINVERT, &inverts));
  VOILE_PETSC(STGetKSP(st, &ksp));
  VOILE_PETSC(KSPGetPC(ksp, &pc));
  VOILE_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &symmetric));
  if (!inverts || !symmetric) return 0;
  MatSolverType solver = nullptr;
  VOILE_PETSC(PCFactorGetMatSolverType(pc, &solver));
  if (!solver || std::string_view(solver) != MATSOLVERMUMPS) return 0;
  VOILE_PETSC(PCFactorGetMatrix(pc, &factor));
  PetscInt count = 0;
  VOILE_PETSC(MatMumpsGetInfog(factor, linear::mumps_negative_pivots, &count));
  return count;
}

/// How many eigenvalues of K - factor M are negative; -1 if the factorisation fails. By Sylvester's law as many of K x = theta M x are
/// below the factor. Collective.
long negative_of(const system::Model& model, double factor, Mat m) {
  petsc::MatHandle shifted;
  VOILE_PETSC(MatDuplicate(model.tangent().matrix(), MAT_COPY_VALUES, shifted.out()));
  VOILE_PETSC(MatAXPY(shifted, -factor, m, SUBSET_NONZERO_PATTERN));
  return linear::inertia_of(shifted).negative;
}

/// Of the modes of one eigenvalue, as of equal parts, a Krylov space that grows from one vector has one, and others by round-off
/// only. Those that it lacks are looked for beside the ones found, until as many precede the last as `preceding` counts.
struct Order {
  std::function<bool(double, double)> precedes;
  std::function<double(double last)> before;    ///< a little before an eigenvalue
  std::function<long(double place)> preceding;  ///< how many there are; -1: not known
};
void add_missed(EPS eps, const system::Model& model, const Order& order, EigenResult& result) {
  constexpr int most_rounds = 30;
  const auto sorted = [&](const Mode& x, const Mode& y) { return order.precedes(x.eigenvalue, y.eigenvalue); };
  std::vector<Mode>& modes = result.modes;
  for (int round = 0; round < most_rounds && !modes.empty(); ++round) {
    if (SignalScope::stop_asked(model.dofs().comm())) return;
    const double place = order.before(modes.back().eigenvalue);
    const auto found =
        std::count_if(modes.begin(), modes.end(), [&](const Mode& m) { return order.precedes(m.eigenvalue, place); });
    result.missed = std::max(0L, order.preceding(place) - static_cast<long>(found));
    if (result.missed == 0) return;
    std::vector<Vec> shapes;
    for (const Mode& m : modes) shapes.push_back(m.shape);
    VOILE_PETSC(EPSSetDeflationSpace(eps, static_cast<PetscInt>(shapes.size()), shapes.data()));
    VOILE_PETSC(EPSSetDimensions(eps, static_cast<PetscInt>(result.missed), PETSC_DEFAULT, PETSC_DEFAULT));
    std::vector<Mode> more = solve(eps, model, static_cast<int>(result.missed));
    if (more.empty()) return;
    for (Mode& m : more) modes.push_back(std::move(m));
    std::stable_sort(modes.begin(), modes.end(), sorted);
    modes.resize(std::min(modes.size(), static_cast<std::size_t>(result.asked_for)));
  }
}

/// Whether options have left what is looked for as it was, and Sylvester's law tells of it.
bool can_count(EPS eps, const system::Model& model, EPSWhich which, double target) {
  EPSWhich now = which;
  PetscScalar at = target;
  VOILE_PETSC(EPSGetWhichEigenpairs(eps, &now));
  VOILE_PETSC(EPSGetTarget(eps, &at));
  return model.conditions().symmetric() && model.tangent().change().empty() && now == which && at == target;
}

/// The modes nearest to `target`, ascending, and how many are below it.
EigenResult modes_from(const system::Model& model, Mat mass, int count, double target, long& below) {
  EigenResult result;
  const EpsHandle eps = create(model, model.tangent().matrix(), mass, count);
  ST st = nullptr;
  VOILE_PETSC(EPSGetST(eps, &st));
  VOILE_PETSC(STSetType(st, STSINVERT));
  VOILE_PETSC(EPSSetTarget(eps, target));
  VOILE_PETSC(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE));
  read_eigen_options(eps);
  const long free = free_unknowns(model);
  if (free == 0) throw UserError("no vertex is free to vibrate; see [[support]]");
  result.asked_for = static_cast<int>(std::min<long>(wanted(eps), free));
  GasSolution gas{model, {}};
  if (!model.tangent().change().empty()) {
    KSP ksp = nullptr;
    VOILE_PETSC(STGetKSP(st, &ksp));
    VOILE_PETSC(KSPSetPostSolve(ksp, GasSolution::complete, &gas));
  }
  result.modes = solve(eps, model, result.asked_for);
  PetscScalar asked = target;
  VOILE_PETSC(EPSGetTarget(eps, &asked));
  // Without symmetry none is below if none is of the symmetric part (Bendixson).
  const bool symmetric = model.conditions().symmetric(), counts = symmetric || !model.tangent().change().empty();
  below = counts ? found_below(eps) : asked == target ? std::max(0L, negative_of(model, target, mass)) : 0;
  if (asked != target) {
    const auto found =
        std::count_if(result.modes.begin(), result.modes.end(), [&](const Mode& m) { return m.eigenvalue < asked; });
    result.lower = std::max(0L, below - static_cast<long>(found));
    below = 0;
  }
  if (!model.tangent().change().empty())
    for (Mode& mode : result.modes) mode.residual = residual_with_gas(model, mass, mode);
  std::stable_sort(result.modes.begin(), result.modes.end(),
                   [](const Mode& x, const Mode& y) { return x.eigenvalue < y.eigenvalue; });
  // Before one that is 0 but for round-off there is only round-off.
  const double zero = small_shift(model);
  if (below == 0 && !result.modes.empty() && result.modes.back().eigenvalue > zero &&
      can_count(eps, model, EPS_TARGET_MAGNITUDE, target))
    add_missed(eps, model,
               {.precedes = std::less<>(),
                .before = [&](double last) { return last - apart * last - 0.5 * zero; },
                .preceding = [&](double place) { return negative_of(model, place, mass); }},
               result);
  return result;
}

}  // namespace

long free_unknowns(const system::Model& model) {
  const auto fixed = static_cast<long>(model.dofs().fixed().size());
  return static_cast<long>(model.dofs().unknowns()) - mpi::sum(model.dofs().comm(), fixed);
}

MassMatrix::MassMatrix(system::Model& model, Vec a, Mass kind) {
  system::require_mass(model);
  (void)model.potential().configuration(a);  // rigid bodies have the mass of the state taken last
  if (kind == Mass::lumped)
    lumped_ = lumped_mass(model);
  else
    consistent_ = model.potential().constant().consistent_mass();
}

double small_shift(const system::Model& model) {
  double stiffness = 0.0, density = 0.0;
  for (const energy::Material& m : model.discretisation().materials()) {
    stiffness = std::max(stiffness, m.bending.norm());
    density = std::max(density, m.areal_density);
  }
  return stiffness / (density * std::pow(model.dofs().mesh().extent(), 4));
}

EigenResult vibration_modes(system::Model& model, Vec a, int count, Mass kind) {
  return vibration_modes(model, a, count, MassMatrix(model, a, kind).mat());
}

EigenResult vibration_modes(system::Model& model, Vec a, int count, Mat mass) {
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  double target = -small_shift(model);
  long below = 0;
  EigenResult result = modes_from(model, mass, count, target, below);
  if (below > 0) {
    // An unstable state: what is nearest to zero is not lowest.
    const long negative = below;
    const double lowest = result.modes.empty() ? target : std::min(target, result.modes.front().eigenvalue);
    target = lowest;
    for (int k = 0; below != 0 && k < most_targets; ++k) below = negative_of(model, target *= target_factor, mass);
    result = modes_from(model, mass, count, target, below);
    if (model.conditions().symmetric()) result.negative = negative;
  }
  for (Mode& mode : result.modes)
    mode.value = std::copysign(std::sqrt(std::abs(mode.eigenvalue)), mode.eigenvalue) / (2.0 * std::numbers::pi);
  return result;
}

EigenResult buckling_modes(Newton& newton, system::Model& model, Vec a, int count) {
  linear::LinearSolver& linear = newton.linear_solver();
  EigenResult result;
  petsc::VecHandle load = model.dofs().create_vector(), load_solution = model.dofs().create_vector();
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  linear.tangent_changed();
  model.load_direction(a, load);
  double size = 0.0;
  if (linear.solve_to(linear::well_solved, load, load_solution))
    VOILE_PETSC(VecNorm(load_solution, NORM_INFINITY, &size));
  else
    throw UserError("analysis = \"buckling\": the response to the load could not be solved (" + linear.take_failure() +
                    "); leave out -ksp_ and -pc_ options, and see that supports stop all rigid motions");
  const bool grows = size > 0.0 || model.potential().natural_growth() > 0.0;
  if (!grows || !std::isfinite(size))
    throw UserError(
        "analysis = \"buckling\" needs a load or a temperature that grows with the load factor, which constant ones "
        "and "
        "those of earlier stages do not, and supports that stop all rigid motions");
  if (linear.negative_eigenvalues() > 0)
    throw UserError(
        "the equilibrium is unstable already; choose a lower eigen.load_factor, or begin at an earlier state");
  const LoadResponse response{model, a, load_solution};
  const petsc::MatHandle change = load_stiffness(response);
  VOILE_PETSC(MatScale(change, -1.0));
  VOILE_PETSC(MatNorm(change, NORM_FROBENIUS, &size));
  result.asked_for = count;
  if (size == 0.0) return result;  // to first order no membrane is stressed
  const EpsHandle eps = create(model, change, model.tangent().matrix(), count);
  VOILE_PETSC(EPSSetWhichEigenpairs(eps, EPS_LARGEST_REAL));
  read_eigen_options(eps);
  result.asked_for = wanted(eps);
  result.modes = solve(eps, model, result.asked_for);
  // Beyond the last positive 1/mu the load only stiffens.
  const auto keep_positive = [&] {
    std::erase_if(result.modes, [](const Mode& mode) { return is_complex(mode) || !(mode.eigenvalue > 0.0); });
  };
  keep_positive();
  if (can_count(eps, model, EPS_LARGEST_REAL, 0.0))
    add_missed(eps, model,
               {.precedes = std::greater<>(),
                .before = [](double last) { return last * (1.0 + apart); },
                .preceding = [&](double place) { return negative_of(model, 1.0 / place, change); }},
               result);
  keep_positive();
  const std::size_t found = result.modes.size();
  VOILE_PETSC(MatScale(change, -1.0));
  drop_round_off(response, change, result.modes);
  if (result.modes.size() < found) result.missed = 0;  // of round-off there are always more
  if (!result.modes.empty())
    result.nonlinearity = nonlinearity(response, linear, 1.0 / result.modes.front().eigenvalue);
  for (Mode& mode : result.modes) mode.value = model.conditions().load_factor() + 1.0 / mode.eigenvalue;
  result.response = std::move(load_solution);
  return result;
}

}  // namespace voile::solve

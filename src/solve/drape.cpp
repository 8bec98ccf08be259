#include "voile/solve/drape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "voile/solve/inverse_iteration.hpp"
#include "voile/solve/stall.hpp"

namespace voile::solve {

namespace {

constexpr int inverse_iterations = 20;
/// Load steps of the cheap way without contact, halved steps included.
constexpr int most_load_steps = 16;
constexpr double first_load_step = 0.25;
/// From the unloaded state to the load factor in force by Newton's method; on failure `a` is unloaded again.
/// Collective.
bool ramp(Newton& newton, system::Model& model, Vec a, NewtonResult& result) {
  double norm = 0.0;
  VOILE_PETSC(VecNorm(a, NORM_2, &norm));
  const double full = model.load_factor();
  if (model.contact() || !model.symmetric() || norm > 0.0 || full == 0.0) return false;
  petsc::VecHandle accepted = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(a, accepted));
  double done = 0.0, step = first_load_step;
  bool stable = true;
  for (int k = 0; k < most_load_steps && done < 1.0 && stable; ++k) {
    const double target = std::min(1.0, done + step);
    model.set_load_factor(target * full);
    const NewtonResult n = newton.step(a);
    result.iterations += n.iterations;
    stable = !n.converged || n.negative_pivots == 0;
    if (!n.converged) {
      step *= 0.5;
      VOILE_PETSC(VecCopy(accepted, a));
      continue;
    }
    VOILE_PETSC(VecCopy(a, accepted));
    done = target;
    if (n.iterations <= 8) step *= 2.0;
    result.converged = stable && done == 1.0;
    result.residual = n.residual;
    result.reason = n.reason;
  }
  model.set_load_factor(full);
  if (!result.converged) VOILE_PETSC(VecZeroEntries(a));
  return result.converged;
}

}  // namespace

DrapeResult drape(system::Model& model, Vec a, const DrapeOptions& options,
                  const std::function<void(const std::string&)>& remark) {
  Newton newton(model);
  LinearSolver& linear = newton.linear_solver();
  DrapeResult result;
  petsc::VecHandle mode = start_mode(model), residual = model.dofs().create_vector();
  const double cell = std::sqrt(model.total_area() / model.mesh().triangle_count());
  int iterations = 0;
  newton.start_friction(a);
  if (remark)
    newton.on_progress([&](int iteration, double norm) {
      remark(fmt::format("search: {} iterations, residual {:.2e}", iteration, norm));
    });
  const int before = linear.factorisations();
  for (;; ++result.escapes) {
    const auto search = [&] { return newton.continuation(a, options.max_iterations); };
    result.newton = {};
    if (result.escapes > 0 || !ramp(newton, model, a, result.newton))
      result.newton = newton.settle_friction(a, search(), search);
    iterations += result.newton.iterations;
    system::TangentRequest request;
    request.exact_contact = true;
    model.assemble_tangent(a, request);
    linear.tangent_changed();
    const bool factored = linear.factorise();
    result.newton.negative_pivots = factored ? linear.negative_pivots() : -1;
    result.stable = result.newton.negative_pivots == 0;
    result.eigenvalue = factored ? inverse_iteration(model, linear, mode, inverse_iterations) : 0.0;
    if (remark)
      remark(fmt::format("{} after {} iterations, residual {:.2e}, {} negative pivot(s)",
                         result.newton.converged ? "equilibrium" : "no equilibrium", result.newton.iterations,
                         result.newton.residual, result.newton.negative_pivots));
    if (!result.newton.converged || result.newton.negative_pivots <= 0 || result.escapes == options.max_escapes) break;
    double largest = 0.0;
    VOILE_PETSC(VecNorm(mode, NORM_INFINITY, &largest));
    VOILE_PETSC(VecScale(mode, options.push * cell / largest));
    VOILE_PETSC(VecAXPY(a, model.contact() ? model.contact()->safe_share(a, mode) : 1.0, mode));
  }
  model.residual(a, residual);
  VOILE_PETSC(VecNorm(residual, NORM_2, &result.residual));
  if (!result.newton.converged) {
    model.dofs().clear_fixed(residual);
    result.newton.reason += "; " + largest_residuals(model, residual);
  }
  result.newton.iterations = iterations;
  result.newton.factorisations = linear.factorisations() - before;
  return result;
}

}  // namespace voile::solve

#include "voile/solve/drape.hpp"

#include <fmt/format.h>

#include <cmath>

#include "voile/solve/inverse_iteration.hpp"

namespace voile::solve {

namespace {

constexpr int inverse_iterations = 20;

}  // namespace

DrapeResult drape(system::Model& model, Vec a, const DrapeOptions& options,
                  const std::function<void(const std::string&)>& remark) {
  Newton newton(model);
  LinearSolver& linear = newton.linear_solver();
  DrapeResult result;
  petsc::VecHandle mode = start_mode(model), residual = model.create_vector();
  const double cell = std::sqrt(model.total_area() / model.mesh().triangle_count());
  int iterations = 0;
  newton.start_friction(a);
  const int before = linear.factorisations();
  for (;; ++result.escapes) {
    result.newton = newton.settle_friction(a, newton.continuation(a, options.max_iterations),
                                           [&] { return newton.continuation(a, options.max_iterations); });
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
  result.newton.iterations = iterations;
  result.newton.factorisations = linear.factorisations() - before;
  return result;
}

}  // namespace voile::solve

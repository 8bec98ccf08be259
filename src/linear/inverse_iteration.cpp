#include "inverse_iteration.hpp"

#include <cmath>

namespace voile::linear {

namespace {

double weighted_dot(const system::Model& model, Vec x, Vec y, Vec scratch) {
  double value = 0.0;
  VOILE_PETSC(VecPointwiseMult(scratch, model.potential().constant().mass(), x));
  VOILE_PETSC(VecDot(scratch, y, &value));
  return value;
}

}  // namespace

petsc::VecHandle start_mode(const system::Model& model) {
  petsc::VecHandle mode = model.dofs().create_vector(), scratch = model.dofs().create_vector();
  std::vector<double> values(static_cast<std::size_t>(model.dofs().unknowns()));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(12.9898 * static_cast<double>(i) + 1.0);
  model.dofs().scatter(values, mode);
  model.dofs().clear_fixed(mode);
  const double size = std::sqrt(weighted_dot(model, mode, mode, scratch));
  if (size > 0.0) VOILE_PETSC(VecScale(mode, 1.0 / size));
  return mode;
}

double inverse_iteration(const system::Model& model, LinearSolver& linear, Vec mode, int iterations) {
  petsc::VecHandle rhs = model.dofs().create_vector(), solution = model.dofs().create_vector(),
                   scratch = model.dofs().create_vector();
  double eigenvalue = 0.0;
  for (int k = 0; k < iterations; ++k) {
    VOILE_PETSC(VecPointwiseMult(rhs, model.potential().constant().mass(), mode));
    model.dofs().clear_fixed(rhs);
    if (!linear.solve(rhs, solution)) break;
    const double inverse = weighted_dot(model, mode, solution, scratch),
                 size = std::sqrt(weighted_dot(model, solution, solution, scratch));
    if (!(size > 0.0) || !std::isfinite(size)) break;
    eigenvalue = inverse != 0.0 ? 1.0 / inverse : 0.0;
    VOILE_PETSC(VecCopy(solution, mode));
    VOILE_PETSC(VecScale(mode, (inverse >= 0.0 ? 1.0 : -1.0) / size));
  }
  return eigenvalue;
}

}  // namespace voile::linear

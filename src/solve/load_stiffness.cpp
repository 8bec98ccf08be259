#include "load_stiffness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "linear/linear_solver.hpp"

namespace voile::solve {

namespace {

/// `larger`: times the usual step.
petsc::MatHandle stiffness_of(const LoadResponse& of, double larger) {
  system::Model& model = of.model;
  double size = 0.0;
  VOILE_PETSC(VecNorm(of.solution, NORM_INFINITY, &size));
  const double cell = std::sqrt(model.discretisation().mean_area());
  const double step = larger * 1e-4 * cell / (size + cell * model.potential().natural_growth()),
               factor = model.conditions().load_factor();
  petsc::VecHandle moved = model.dofs().create_vector();
  petsc::MatHandle difference;
  for (const double sign : {1.0, -1.0}) {
    VOILE_PETSC(VecWAXPY(moved, sign * step, of.solution, of.a));
    model.conditions().set_load_factor(factor + sign * step);
    model.assemble_tangent(moved, {.kind = energy::Tangent::stress_alone, .previous = of.a});
    if (sign > 0.0)
      VOILE_PETSC(MatDuplicate(model.tangent().matrix(), MAT_COPY_VALUES, difference.out()));
    else
      VOILE_PETSC(MatAXPY(difference, -1.0, model.tangent().matrix(), SAME_NONZERO_PATTERN));
  }
  VOILE_PETSC(MatScale(difference, 0.5 / step));
  model.conditions().set_load_factor(factor);
  model.assemble_tangent(of.a, {.kind = energy::Tangent::exact});
  return difference;
}

/// x' A x.
double quadratic_form(Mat matrix, Vec x, Vec work) {
  double value = 0.0;
  VOILE_PETSC(MatMult(matrix, x, work));
  VOILE_PETSC(VecDot(work, x, &value));
  return value;
}

}  // namespace

petsc::MatHandle load_stiffness(const LoadResponse& of) {
  return stiffness_of(of, 1.0);
}

void drop_round_off(const LoadResponse& of, Mat stiffness, std::vector<Mode>& modes) {
  constexpr double larger = 3.0, alike = 0.02;
  const petsc::MatHandle again = stiffness_of(of, larger);
  const petsc::VecHandle work = of.model.dofs().create_vector();
  std::erase_if(modes, [&](const Mode& mode) {
    const double once = quadratic_form(stiffness, mode.shape, work), twice = quadratic_form(again, mode.shape, work);
    return !(std::abs(once - twice) <= alike * std::abs(once));
  });
}

namespace {

/// Norm of displacements that no stiffness changes by: of this fraction of the thickness, sqrt(12 D/A), everywhere.
double small_deflection(const system::Model& model) {
  constexpr double fraction = 0.1;
  double square = std::numeric_limits<double>::infinity();
  for (const energy::Material& m : model.discretisation().materials())
    square = std::min(square, 12.0 * m.bending(0, 0) / m.membrane(0, 0));
  return fraction * std::sqrt(square * static_cast<double>(model.dofs().mesh().vertex_count()));
}

}  // namespace

double nonlinearity(const LoadResponse& of, linear::LinearSolver& linear, double mu) {
  const petsc::VecHandle moved = of.model.dofs().create_vector(), left = of.model.dofs().create_vector(),
                         correction = of.model.dofs().create_vector();
  const double factor = of.model.conditions().load_factor();
  VOILE_PETSC(VecWAXPY(moved, mu, of.solution, of.a));
  of.model.conditions().set_load_factor(factor + mu);
  of.model.residual(moved, left);
  of.model.conditions().set_load_factor(factor);
  of.model.assemble_tangent(of.a, {.kind = energy::Tangent::exact});
  linear.tangent_changed();
  double corrected = 0.0, size = 0.0;
  // So far from an equilibrium that there may be no residual at all.
  if (!linear.solve_to(linear::well_solved, left, correction)) return std::numeric_limits<double>::infinity();
  VOILE_PETSC(VecNorm(correction, NORM_2, &corrected));
  VOILE_PETSC(VecNorm(of.solution, NORM_2, &size));
  return corrected / std::max(mu * size, small_deflection(of.model)) * mu / (factor + mu);
}

}  // namespace voile::solve

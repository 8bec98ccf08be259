#include "load_stiffness.hpp"

#include <cmath>

namespace voile::solve {

petsc::MatHandle load_stiffness(system::Model& model, Vec a, Vec load_solution, double larger) {
  double size = 0.0;
  VOILE_PETSC(VecNorm(load_solution, NORM_INFINITY, &size));
  const double cell = std::sqrt(model.discretisation().mean_area());
  const double step = larger * 1e-4 * cell / (size + cell * model.potential().natural_growth()),
               factor = model.conditions().load_factor();
  petsc::VecHandle moved = model.dofs().create_vector();
  petsc::MatHandle difference;
  for (const double sign : {1.0, -1.0}) {
    VOILE_PETSC(VecWAXPY(moved, sign * step, load_solution, a));
    model.conditions().set_load_factor(factor + sign * step);
    model.assemble_tangent(moved, {.kind = energy::Tangent::stress_alone, .previous = a});
    if (sign > 0.0)
      VOILE_PETSC(MatDuplicate(model.tangent().matrix(), MAT_COPY_VALUES, difference.out()));
    else
      VOILE_PETSC(MatAXPY(difference, -1.0, model.tangent().matrix(), SAME_NONZERO_PATTERN));
  }
  VOILE_PETSC(MatScale(difference, 0.5 / step));
  model.conditions().set_load_factor(factor);
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  return difference;
}

}  // namespace voile::solve

#include "state_change.hpp"

#include <cmath>

namespace voile::record {

StateChange::StateChange(system::Model& model, Vec a, Vec u) : model_(model), a_(a) {
  double largest = 0.0;
  VOILE_PETSC(VecNorm(u, NORM_INFINITY, &largest));
  if (largest > 0.0) step_ = fraction_of_cell * std::sqrt(model.discretisation().mean_area()) / largest;
  for (petsc::VecHandle* v : {&forward_, &backward_}) {
    *v = model.dofs().create_vector();
    VOILE_PETSC(VecCopy(a, *v));
    VOILE_PETSC(VecAXPY(*v, v == &forward_ ? step_ : -step_, u));
  }
}

StateChange::StateChange(system::Model& model, Vec a) : model_(model), a_(a) {}

/// Leaves the model at the state and load factor that it had.
template <class F>
void StateChange::at_sides(F&& f) {
  const double factor = model_.conditions().load_factor();
  for (const double sign : {1.0, -1.0}) {
    if (!forward_) model_.conditions().set_load_factor(factor + sign);
    f(!forward_ ? a_ : sign > 0.0 ? static_cast<Vec>(forward_) : static_cast<Vec>(backward_), 0.5 * sign / step_);
  }
  model_.conditions().set_load_factor(factor);
  (void)model_.potential().configuration(a_);
}

void StateChange::force(Vec f) {
  VOILE_PETSC(VecZeroEntries(f));
  const petsc::VecHandle side = model_.dofs().create_vector();
  at_sides([&](Vec x, double weight) {
    model_.unbalanced_force(x, side);
    VOILE_PETSC(VecAXPY(f, weight, side));
  });
}

std::vector<double> StateChange::of_fields(const std::function<std::vector<double>(const system::TriangleFields&)>& f) {
  std::vector<double> change;
  at_sides([&](Vec x, double weight) {
    const system::TriangleFields fields = model_.triangle_fields(x);
    if (mpi::rank(model_.dofs().comm()) != 0) return;
    const std::vector<double> values = f(fields);
    change.resize(values.size(), 0.0);
    for (std::size_t i = 0; i < values.size(); ++i) change[i] += weight * values[i];
  });
  return change;
}

}  // namespace voile::record

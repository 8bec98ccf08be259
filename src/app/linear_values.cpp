#include "linear_values.hpp"

#include <cmath>

namespace voile::app {

namespace {

/// Largest displacement of e u over the length of a cell: terms of third order are its square, and round-off of the coordinates is
/// divided by it, so about the cube root of round-off.
constexpr double share_of_cell = 1e-5;

}  // namespace

LinearValues::LinearValues(system::Model& model, Vec u, Vec about) : model_(model), u_(u) {
  double largest = 0.0;
  VOILE_PETSC(VecNorm(u, NORM_INFINITY, &largest));
  if (largest > 0.0) small_ = share_of_cell * std::sqrt(model.discretisation().mean_area()) / largest;
  for (petsc::VecHandle* v : {&rest_, &forward_, &backward_}) *v = model.dofs().create_vector();
  for (Vec v : {static_cast<Vec>(rest_), static_cast<Vec>(forward_), static_cast<Vec>(backward_)})
    VOILE_PETSC(about ? VecCopy(about, v) : VecZeroEntries(v));
  VOILE_PETSC(VecAXPY(forward_, small_, u));
  VOILE_PETSC(VecAXPY(backward_, -small_, u));
}

void LinearValues::unbalanced_force(Vec f) {
  const petsc::VecHandle other = model_.dofs().create_vector();
  model_.unbalanced_force(forward_, f);
  model_.unbalanced_force(backward_, other);
  VOILE_PETSC(VecAXPY(f, -1.0, other));
  VOILE_PETSC(VecScale(f, 0.5 / small_));
  model_.unbalanced_force(rest_, other);
  VOILE_PETSC(VecAXPY(f, 1.0, other));
}

system::Energies LinearValues::energies() {
  system::Energies at = system::energies(model_, rest_);
  const system::Energies up = system::energies(model_, forward_), down = system::energies(model_, backward_);
  using E = system::Energies;
  const double before = at.membrane + at.bending + at.springs + at.external;
  for (double E::*part : {&E::membrane, &E::springs}) {
    const double even = up.*part + down.*part - 2.0 * at.*part;
    at.*part += 0.5 * (up.*part - down.*part) / small_ + 0.5 * even / (small_ * small_);
  }
  at.external += 0.5 * (up.external - down.external) / small_;  // that of dead loads
  // Of a curved rest shape the energy of so small a bending is lost in the round-off of the normals, that of all is not.
  at.bending = before + work() - at.membrane - at.springs - at.external;
  return at;
}

double LinearValues::work() {
  const petsc::VecHandle f = model_.dofs().create_vector(), start = model_.dofs().create_vector();
  unbalanced_force(f);
  model_.dofs().clear_free(f);  // it is solved there: what is left is the round-off of the applied forces
  model_.unbalanced_force(rest_, start);
  VOILE_PETSC(VecAXPY(f, 1.0, start));
  double sum = 0.0;
  VOILE_PETSC(VecDot(f, forward_, &sum));
  return 0.5 * sum / small_;
}

double LinearValues::stiffness() {
  const petsc::VecHandle f = model_.dofs().create_vector(), other = model_.dofs().create_vector();
  model_.unbalanced_force(forward_, f);
  model_.unbalanced_force(backward_, other);
  VOILE_PETSC(VecAXPY(f, -1.0, other));
  double sum = 0.0;
  VOILE_PETSC(VecDot(f, u_, &sum));
  return std::abs(0.5 * sum / small_);
}

system::TriangleFields LinearValues::triangle_changes() {
  const system::TriangleFields whole = triangle_fields(), at = model_.potential().triangle_fields(rest_);
  system::TriangleFields change = whole;
  using F = system::TriangleFields;
  for (std::vector<double> F::*field :
       {&F::membrane_strain, &F::membrane_force, &F::curvature, &F::whole_curvature, &F::bending_moment, &F::in_plane})
    for (std::size_t i = 0; i < (change.*field).size(); ++i) (change.*field)[i] -= (at.*field)[i];
  return change;
}

system::TriangleFields LinearValues::triangle_fields() {
  system::TriangleFields at = model_.potential().triangle_fields(rest_);
  const system::TriangleFields up = model_.potential().triangle_fields(forward_),
                               down = model_.potential().triangle_fields(backward_);
  using F = system::TriangleFields;
  for (std::vector<double> F::*field :
       {&F::membrane_strain, &F::membrane_force, &F::curvature, &F::whole_curvature, &F::bending_moment})
    for (std::size_t i = 0; i < (at.*field).size(); ++i)
      (at.*field)[i] += 0.5 * ((up.*field)[i] - (down.*field)[i]) / small_;
  for (std::size_t i = 0; i < at.in_plane.size(); ++i)
    at.in_plane[i] += 0.5 * (up.in_plane[i] + down.in_plane[i] - 2.0 * at.in_plane[i]) / (small_ * small_);
  return at;
}

}  // namespace voile::app

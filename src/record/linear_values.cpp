#include "linear_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "state_change.hpp"

namespace voile::record {

namespace {

using LinearField = std::vector<double> system::TriangleFields::*;
constexpr std::array<LinearField, 5> linear_fields{
    &system::TriangleFields::membrane_strain, &system::TriangleFields::membrane_force,
    &system::TriangleFields::curvature, &system::TriangleFields::whole_curvature,
    &system::TriangleFields::bending_moment};

}  // namespace

LinearValues::LinearValues(system::Model& model, Vec u, Vec about) : model_(model), u_(u) {
  double largest = 0.0;
  VOILE_PETSC(VecNorm(u, NORM_INFINITY, &largest));
  if (largest > 0.0) small_ = fraction_of_cell * std::sqrt(model.discretisation().mean_area()) / largest;
  for (petsc::VecHandle* v : {&rest_, &forward_, &backward_}) *v = model.dofs().create_vector();
  for (Vec v : {static_cast<Vec>(rest_), static_cast<Vec>(forward_), static_cast<Vec>(backward_)})
    VOILE_PETSC(about ? VecCopy(about, v) : VecZeroEntries(v));
  VOILE_PETSC(VecAXPY(forward_, small_, u));
  VOILE_PETSC(VecAXPY(backward_, -small_, u));
}

void LinearValues::unbalanced_force(Vec f) {
  const petsc::VecHandle other = model_.dofs().create_vector();
  model_.potential().hold_natural_states(true);
  model_.unbalanced_force(forward_, f);
  model_.unbalanced_force(backward_, other);
  model_.potential().hold_natural_states(false);
  VOILE_PETSC(VecAXPY(f, -1.0, other));
  model_.applied_forces(forward_, other);  // loads are those of the start
  VOILE_PETSC(VecAXPY(f, 1.0, other));
  model_.applied_forces(backward_, other);
  VOILE_PETSC(VecAXPY(f, -1.0, other));
  VOILE_PETSC(VecScale(f, 0.5 / small_));
  model_.unbalanced_force(rest_, other);
  VOILE_PETSC(VecAXPY(f, 1.0, other));
}

system::Energies LinearValues::energies() {
  system::Energies at = system::energies(model_, rest_);
  const system::Energies up = system::energies(model_, forward_), down = system::energies(model_, backward_);
  system::Energies even_up = up, even_down = down, held = at;
  if (model_.potential().natural_states_change()) {  // what grows with the load stiffens nothing
    model_.potential().hold_natural_states(true);
    even_up = system::energies(model_, forward_);
    even_down = system::energies(model_, backward_);
    held = system::energies(model_, rest_);
    model_.potential().hold_natural_states(false);
  }
  using E = system::Energies;
  const double before = at.membrane + at.bending + at.springs + at.external;
  for (double E::*part : {&E::membrane, &E::springs}) {
    const double even = even_up.*part + even_down.*part - 2.0 * held.*part;
    at.*part += 0.5 * (up.*part - down.*part) / small_ + 0.5 * even / (small_ * small_);
  }
  at.external += 0.5 * (up.external - down.external) / small_;  // that of dead loads
  // Of a curved rest shape the energy of so small a bending is lost in the round-off of the normals, that of all is not.
  at.bending = before + work() + follower_work() - at.membrane - at.springs - at.external;
  return at;
}

double LinearValues::follower_work() {
  const petsc::VecHandle f = model_.dofs().create_vector();
  double sum = 0.0;
  model_.follower_forces(rest_, f);
  VOILE_PETSC(VecDot(f, u_, &sum));
  return sum;
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
  const auto fields_at = [&](Vec a) { return model_.triangle_fields(a); };
  model_.potential().hold_natural_states(
      true);  // in all three, so that differences of second order are those of u alone
  const system::TriangleFields up = fields_at(forward_), down = fields_at(backward_);
  system::TriangleFields change = fields_at(rest_);
  model_.potential().hold_natural_states(false);
  for (std::size_t i = 0; i < change.in_plane.size(); ++i)
    change.in_plane[i] = 0.5 * (up.in_plane[i] + down.in_plane[i] - 2.0 * change.in_plane[i]) / (small_ * small_);
  for (LinearField field : linear_fields)
    for (std::size_t i = 0; i < (change.*field).size(); ++i)
      (change.*field)[i] = 0.5 * ((up.*field)[i] - (down.*field)[i]) / small_;
  return change;
}

system::TriangleFields LinearValues::triangle_fields() {
  system::TriangleFields all = model_.triangle_fields(rest_);
  const system::TriangleFields change = triangle_changes();
  const auto add = [&](LinearField field) {
    for (std::size_t i = 0; i < (all.*field).size(); ++i) (all.*field)[i] += (change.*field)[i];
  };
  std::for_each(linear_fields.begin(), linear_fields.end(), add);
  add(&system::TriangleFields::in_plane);
  return all;
}

}  // namespace voile::record

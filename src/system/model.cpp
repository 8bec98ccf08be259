#include "voile/system/model.hpp"

#include <algorithm>
#include <cmath>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"
#include "voile/energy/membrane.hpp"
#include "voile/system/bands.hpp"
#include "voile/system/bending_energy.hpp"
#include "voile/system/contact.hpp"
#include "voile/system/sewing_springs.hpp"
#include "voile/system/term.hpp"

namespace voile::system {

void Model::set_time(double time) {
  if (contact_) contact_->set_time(time);
  if (held_still_) return;
  conditions_->set_time(time);
  attachments_->place();
  bands_->tighten(time);
  if (!sewing_) return;
  sewing_->tighten(time);
  drawn_in_ = sewing_->drawn_in(time);
  membrane_->kernel.gather(drawn_in_);
}

void Model::hold_still(bool still) {
  held_still_ = still;
  if (contact_) contact_->scene().hold_obstacles(still);
}

energy::Configuration Model::configuration(Vec a) {
  bending_->turn(conditions_->rotations());
  attachments_->place();
  dofs().update_points(a, u_, x_);
  return {x_.data(), u_.data(), nullptr, energy::Tangent::exact};
}

void Model::unbalanced_force(Vec a, Vec f) {
  const energy::Configuration c = configuration(a);
  bending_->force(a, f);
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  for (const Counted& t : terms_) t.term->add_forces(c, force_);
  dofs().add_forces(force_, f);
  if (contact_) contact_->add_gradient(a, f);
  // Applied forces collect in work_, so that their size is known.
  conditions_->applied_forces(c, force_, work_);
  VOILE_PETSC(VecAXPY(f, -1.0, work_));
}

void Model::residual(Vec a, Vec r) {
  const petsc::EventScope scope(petsc::events().residual);
  unbalanced_force(a, r);
  double applied = 0.0, reaction = 0.0;
  VOILE_PETSC(VecNorm(work_, NORM_2, &applied));
  {
    const petsc::WriteArray out(r);
    for (PetscInt i : dofs().fixed()) reaction += out[i] * out[i];
    conditions_->write_off(petsc::ReadArray(a), out);
  }
  force_scale_ = std::max(applied, std::sqrt(mpi::sum(comm(), reaction)));
}

Energies Model::energies(Vec a, bool with_contact) {
  const petsc::EventScope scope(petsc::events().energy);
  const std::vector<double> viscosity = membrane_->kernel.viscosity();
  membrane_->kernel.set_viscosity({});
  Energies e = energies_of_sheet(a);
  membrane_->kernel.set_viscosity(viscosity);
  if (contact_ && with_contact) e.contact = contact_->energy(a, contact::ContactSet::normal);
  return e;
}

void Model::count_energy_from(Vec a) {
  bending_->count_from(a);
}

Energies Model::energies_of_sheet(Vec a) {
  Energies e;
  const energy::Configuration c = configuration(a);
  for (const Counted& t : terms_) e.*t.part += mpi::sum(comm(), t.term->energy(c));
  const double ground = bending_->ground_energy(a);
  e.bending += bending_->energy(a) - ground;
  e.springs += ground;
  e.external = conditions_->potential(a);
  return e;
}

double Model::energy(Vec a) {
  const petsc::EventScope scope(petsc::events().energy);
  const Energies e = energies_of_sheet(a);
  const double sheet = e.membrane + e.bending + e.springs + e.external;
  return contact_ ? sheet + contact_->energy(a) : sheet;
}

void Model::start_step(Vec a, double viscosity, double inverse_step) {
  membrane_->kernel.start_step(configuration(a), viscosity, inverse_step);
}

void Model::assemble_tangent(Vec a, const TangentRequest& request) {
  const petsc::EventScope scope(petsc::events().tangent);
  BlockMatrix& tangent = tangent_.blocks();
  const BlockMatrix& base = constant_.base();
  if (contact_)
    if (BlockPattern pattern; contact_->extend_pattern(a, tangent, base.pattern(), pattern))
      tangent_.extend(base, std::move(pattern));
  energy::Configuration c = configuration(a);
  c.tangent = request.kind;
  if (request.previous) {
    dofs().update_points(request.previous, previous_u_, previous_x_);
    c.previous = previous_x_.data();
  }
  const BlockMatrix::Values values = tangent.open();
  {
    const petsc::EventScope copy(petsc::events().bending_copy);
    tangent.clear();
    constant_.add_bending(tangent, values, request.bending);
    if (constant_.has_damping() && request.damping > 0.0) constant_.add_damping(tangent, values, request.damping);
  }
  const int pattern = tangent_.pattern_version();
  for (const Counted& t : terms_) t.term->add_blocks(c, dofs(), tangent, pattern, values);
  conditions_->add_blocks(c, tangent, pattern, values);
  if (request.extra) request.extra->add_blocks(c, dofs(), tangent, pattern, values);
  if (request.mass > 0.0 && request.mass_matrix)
    tangent.add_values_from(*request.mass_matrix, request.mass);
  else if (request.mass > 0.0)
    tangent_.add_mass(values, request.masses ? request.masses : constant_.mass(), request.mass);
  if (contact_) contact_->add_blocks(tangent, values, !request.exact_contact);
  if (!conditions_->has_prescribed()) return tangent_.close(values, nullptr, nullptr);
  VOILE_PETSC(VecZeroEntries(work_));
  conditions_->write_off(petsc::ReadArray(a), petsc::WriteArray(work_));
  tangent_.close(values, work_, conditions_->prescribed());
}

std::vector<double> Model::owned_places() const {
  std::vector<double> places;
  for (Index i = 0; i < dofs().local().owned; ++i) places.insert(places.end(), x_[i].data(), x_[i].data() + 3);
  return places;
}

void Model::load_direction(Vec a, Vec f) {
  conditions_->load_direction(configuration(a), force_, work_, f);
  if (conditions_->has_prescribed()) VOILE_PETSC(VecAXPY(f, -1.0, tangent_.load_coupling()));
  const petsc::ReadArray prescribed(conditions_->prescribed());
  const petsc::WriteArray out(f);
  for (PetscInt i : dofs().fixed()) out[i] = prescribed[i];
}

TriangleFields Model::triangle_fields(Vec a) {
  return recovery_.fields(comm(), on_->sheet(), membrane_->kernel, configuration(a));
}

long Model::uncorrected_triangles() const {
  const energy::MembraneTerm& kernel = membrane_->kernel;
  long count = 0;
  for (Index e = 0; e < kernel.size(); ++e) count += kernel.owned(e) && kernel.left_out(e) ? 1 : 0;
  return mpi::sum(comm(), count);
}

}  // namespace voile::system

#include "voile/system/model.hpp"

#include <algorithm>
#include <cmath>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"

namespace voile::system {

void Model::enforce_supports(Vec a) const {
  const petsc::ReadArray prescribed(prescribed_), motion(motion_), hold(hold_);
  const petsc::WriteArray values(a);
  for (PetscInt i : dofs_->fixed()) values[i] = load_factor_ * prescribed[i] + motion[i] + hold[i];
}

void Model::take_hold(Vec a, double time, double load_factor) {
  move_supports(time);
  const petsc::ReadArray unknown(a), prescribed(prescribed_), motion(motion_);
  const petsc::WriteArray hold(hold_);
  for (PetscInt i : dofs_->fixed()) hold[i] = unknown[i] - load_factor * prescribed[i] - motion[i];
}

energy::Configuration Model::configuration(Vec a) {
  dofs_->update_points(a, u_, x_);
  return {x_.data(), u_.data(), nullptr, energy::Tangent::exact};
}

void Model::add_term_forces(const Term& term, const energy::Configuration& c, Vec f) {
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  term.add_forces(c, force_);
  dofs_->add_forces(force_, f);
}

void Model::unbalanced_force(Vec a, Vec f) {
  VOILE_PETSC(MatMultAdd(bending_.mat(), a, bending_force_, f));
  const energy::Configuration c = configuration(a);
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  for (const Counted& t : terms_) t.term->add_forces(c, force_);
  dofs_->add_forces(force_, f);
  if (contact_) contact_->add_gradient(a, f);
  // Applied forces collect in work_, so that their size is known.
  VOILE_PETSC(VecZeroEntries(work_));
  add_term_forces(followers_, c, work_);
  VOILE_PETSC(VecScale(work_, -1.0));
  VOILE_PETSC(VecAXPY(work_, 1.0, constant_));
  VOILE_PETSC(VecAXPY(work_, load_factor_, dead_));
  VOILE_PETSC(VecAXPY(f, -1.0, work_));
}

void Model::residual(Vec a, Vec r) {
  const petsc::EventScope scope(petsc::events().residual);
  unbalanced_force(a, r);
  double applied = 0.0, reaction = 0.0;
  VOILE_PETSC(VecNorm(work_, NORM_2, &applied));
  {
    const petsc::WriteArray out(r);
    const petsc::ReadArray unknown(a), prescribed(prescribed_), motion(motion_), hold(hold_);
    for (PetscInt i : dofs_->fixed()) {
      reaction += out[i] * out[i];
      out[i] = unknown[i] - load_factor_ * prescribed[i] - motion[i] - hold[i];
    }
  }
  force_scale_ = std::max(applied, std::sqrt(mpi::sum(comm(), reaction)));
}

Energies Model::energies(Vec a) {
  const std::vector<double> viscosity = membrane_->kernel.viscosity();
  membrane_->kernel.set_viscosity({});
  const Energies e = energies_of_step(a);
  membrane_->kernel.set_viscosity(viscosity);
  return e;
}

void Model::count_energy_from(Vec a) {
  VOILE_PETSC(VecCopy(a, reference_));
  VOILE_PETSC(MatMult(bending_.mat(), a, work_));
  VOILE_PETSC(VecAXPY(work_, 2.0, bending_force_));
  VOILE_PETSC(VecDot(work_, a, &reference_bending_));
  reference_bending_ += bending_offset_;
}

Energies Model::energies_of_step(Vec a) {
  const petsc::EventScope scope(petsc::events().energy);
  Energies e;
  const energy::Configuration c = configuration(a);
  double bending = 0.0, constant = 0.0, dead = 0.0;
  VOILE_PETSC(VecWAXPY(sum_, 1.0, reference_, a));
  VOILE_PETSC(MatMult(bending_.mat(), sum_, work_));
  VOILE_PETSC(VecAXPY(work_, 2.0, bending_force_));
  VOILE_PETSC(VecWAXPY(sum_, -1.0, reference_, a));
  VOILE_PETSC(VecDot(work_, sum_, &bending));
  VOILE_PETSC(VecDot(constant_, a, &constant));
  VOILE_PETSC(VecDot(dead_, a, &dead));
  for (const Counted& t : terms_) e.*t.part += mpi::sum(comm(), t.term->energy(c));
  const double ground = spring_energy(a);
  e.bending += 0.5 * (reference_bending_ + bending) - ground;  // springs to the ground are part of the constant matrix
  e.springs += ground;
  e.external = -constant - load_factor_ * dead;
  if (contact_) e.contact = contact_->energy(a);
  return e;
}

double Model::energy(Vec a) {
  const Energies e = energies_of_step(a);
  return e.membrane + e.bending + e.springs + e.external + e.contact;
}

void Model::start_step(Vec a, double viscosity, double inverse_step) {
  membrane_->kernel.start_step(configuration(a), viscosity, inverse_step);
}

void Model::assemble_tangent(Vec a, Vec previous, energy::Tangent tangent, double shift) {
  TangentRequest request;
  request.kind = tangent;
  request.previous = previous;
  request.mass = shift;
  assemble_tangent(a, request);
}

void Model::assemble_tangent(Vec a, const TangentRequest& request) {
  const petsc::EventScope scope(petsc::events().tangent);
  if (contact_)
    if (BlockPattern pattern = bending_.pattern(); contact_->extend_pattern(a, tangent_, pattern))
      extend_tangent(std::move(pattern));
  energy::Configuration c = configuration(a);
  c.tangent = request.kind;
  if (request.previous) {
    dofs_->update_points(request.previous, previous_u_, previous_x_);
    c.previous = previous_x_.data();
  }
  const BlockMatrix::Values values = tangent_.open();
  {
    const petsc::EventScope copy(petsc::events().bending_copy);
    tangent_.copy_values_from(bending_);
    if (request.bending != 1.0) tangent_.add_values_from(bending_, request.bending - 1.0);
    if (damping_ && request.damping > 0.0) tangent_.add_values_from(*damping_, request.damping);
  }
  const auto add = [&](Term& term) { term.add_blocks(c, *dofs_, tangent_, pattern_version_, values); };
  for (const Counted& t : terms_) add(*t.term);
  add(followers_);
  if (request.extra) add(*request.extra);
  if (request.mass > 0.0 && request.mass_matrix) tangent_.add_values_from(*request.mass_matrix, request.mass);
  if (request.mass > 0.0 && !request.mass_matrix) {
    const petsc::ReadArray mass(mass_);
    for (Index i = 0; i < dofs_->local().owned; ++i)
      values.add(mass_slots_[i], Mat3(Eigen::Map<const Vec3>(mass.data() + 3 * i).asDiagonal()) * request.mass);
  }
  if (contact_) contact_->add_blocks(tangent_, values, !request.exact_contact);
  has_coupling_ = false;
  if (has_prescribed_) {
    tangent_.close();
    find_coupling(a);
    VOILE_PETSC(MatMult(tangent_.mat(), prescribed_, load_coupling_));
    eliminate(eliminated_, tangent_.open());
  } else {
    eliminate(eliminated_, values);
  }
  tangent_.close();
}

BlockMatrix Model::consistent_mass() const {
  BlockMatrix mass = bending_.twin();
  const BlockMatrix::Values values = mass.open();
  for (Index t = 0; t < mesh_->triangle_count(); ++t) {
    const double part = sheet_->material(t).areal_density * mesh_->area(t) / 12.0;
    for (Index v : mesh_->triangles()[t]) {
      const Index i = owned(v);
      if (i == no_index) continue;
      for (Index w : mesh_->triangles()[t])
        values.add(mass.slot(i, partition_.row_of[w]),
                   (v == w ? 2.0 : 1.0) * part * dofs_->axes(v).transpose() * dofs_->axes(w));
    }
  }
  for (const auto& [i, m] : masses_) values.add(mass.slot(i, dofs_->first_row() + i), m * Mat3::Identity());
  eliminate(base_eliminated_, values);
  for (Index at : base_eliminated_.unit) values.diagonal[at] = 0.0;
  mass.close();
  return mass;
}

void Model::find_coupling(Vec a) {
  VOILE_PETSC(VecZeroEntries(work_));
  {
    const petsc::WriteArray off(work_);
    const petsc::ReadArray unknown(a), prescribed(prescribed_), motion(motion_), hold(hold_);
    for (PetscInt i : dofs_->fixed()) off[i] = unknown[i] - load_factor_ * prescribed[i] - motion[i] - hold[i];
  }
  double size = 0.0;
  VOILE_PETSC(VecNorm(work_, NORM_INFINITY, &size));
  if (size == 0.0) return;
  has_coupling_ = true;
  VOILE_PETSC(MatMult(tangent_.mat(), work_, coupling_));
  const petsc::WriteArray coupling(coupling_);
  for (PetscInt i : dofs_->fixed()) coupling[i] = 0.0;
}

void Model::eliminate(const Eliminated& entries, const BlockMatrix::Values& values) {
  for (Index at : entries.diagonal) values.diagonal[at] = 0.0;
  for (Index at : entries.off_diagonal) values.off_diagonal[at] = 0.0;
  for (Index at : entries.unit) values.diagonal[at] = 1.0;
}

void Model::extend_tangent(BlockPattern pattern) {
  tangent_.extend(bending_, std::move(pattern));
  eliminated_ = find_eliminated_entries(tangent_);
  for (Index i = 0; i < dofs_->local().owned; ++i) mass_slots_[i] = tangent_.slot(i, dofs_->first_row() + i);
  ++pattern_version_;
}

void Model::load_direction(Vec a, Vec f) {
  VOILE_PETSC(VecCopy(dead_, f));
  if (any_follower_) {
    // Follower loads are linear in the load factor: a difference over one unit is exact.
    const energy::Configuration c = configuration(a);
    for (const double sign : {1.0, -1.0}) {
      followers_.kernel.set_factor(energy::FollowerTerm::load_factor, load_factor_ + (sign > 0.0 ? 1.0 : 0.0));
      VOILE_PETSC(VecZeroEntries(work_));
      add_term_forces(followers_, c, work_);
      VOILE_PETSC(VecAXPY(f, -sign, work_));
    }
  }
  if (has_prescribed_) VOILE_PETSC(VecAXPY(f, -1.0, load_coupling_));
  const petsc::ReadArray prescribed(prescribed_);
  const petsc::WriteArray out(f);
  for (PetscInt i : dofs_->fixed()) out[i] = prescribed[i];
}

TriangleFields Model::triangle_fields(Vec a) {
  return recovery_.fields(comm(), *sheet_, membrane_->kernel, configuration(a));
}

}  // namespace voile::system

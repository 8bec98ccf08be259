#include "voile/system/model.hpp"

#include <algorithm>
#include <cmath>

#include "model_assembly.hpp"
#include "voile/base/error.hpp"

namespace voile::system {

petsc::VecHandle Model::create_vector() const {
  petsc::VecHandle v;
  VOILE_PETSC(VecDuplicate(work_, v.out()));
  VOILE_PETSC(VecZeroEntries(v));
  return v;
}

void Model::set_load_factor(double factor) {
  load_factor_ = factor;
  followers_.term.set_factor(energy::FollowerTerm::load_factor, factor);
}

void Model::set_time(double time) {
  if (contact_) contact_->set_time(time);
  if (!timed_.empty()) VOILE_PETSC(VecCopy(always_, constant_));
  for (const TimedLoad& load : timed_) {
    const double factor = load.history(time);
    VOILE_PETSC(VecAXPY(constant_, factor, load.force));
    followers_.term.set_factor(load.factor, factor);
  }
  if (movers_.empty()) return;
  const petsc::WriteArray motion(motion_);
  for (const Mover& m : movers_) {
    const Vec3 u = supports_[static_cast<std::size_t>(m.support)].motion(rest_[m.local], time);
    const Index axes = rotated_index_[m.local];
    const Vec3 own = axes == no_index ? u : Vec3(rotated_[axes].second.transpose() * u);
    for (int k = 0; k < 3; ++k) motion[3 * m.local + k] = own[k];
  }
}

void Model::enforce_supports(Vec a) const {
  const petsc::ReadArray prescribed(prescribed_), motion(motion_);
  const petsc::WriteArray values(a);
  for (PetscInt i : fixed_) values[i] = load_factor_ * prescribed[i] + motion[i];
}

void Model::update_points(Vec a, std::vector<Vec3>& u, std::vector<Vec3>& x) const {
  VOILE_PETSC(VecScatterBegin(scatter_, a, local_vector_, INSERT_VALUES, SCATTER_FORWARD));
  VOILE_PETSC(VecScatterEnd(scatter_, a, local_vector_, INSERT_VALUES, SCATTER_FORWARD));
  const petsc::ReadArray values(local_vector_);
  for (Index i = 0; i < local_vertices_; ++i) u[i] = Eigen::Map<const Vec3>(values.data() + 3 * i);
  for (const auto& [i, axes] : rotated_) u[i] = axes * u[i];
  for (std::size_t m = 0; m < mirrors_.size(); ++m) {
    const LocalMirror& g = mirrors_[m];
    const Vec3 foot = (1.0 - g.foot) * u[g.a] + g.foot * u[g.b];
    u[static_cast<std::size_t>(local_vertices_) + m] = foot + g.reflection * (u[g.apex] - foot);
  }
  for (std::size_t i = 0; i < u.size(); ++i) x[i] = rest_[i] + u[i];
}

void Model::fold_forces(std::vector<Vec3>& f) const {
  for (std::size_t m = 0; m < mirrors_.size(); ++m) {
    const LocalMirror& g = mirrors_[m];
    const Vec3 force = f[static_cast<std::size_t>(local_vertices_) + m];
    const Vec3 mirrored = g.reflection.transpose() * force;
    f[g.apex] += mirrored;
    f[g.a] += (1.0 - g.foot) * (force - mirrored);
    f[g.b] += g.foot * (force - mirrored);
  }
  for (const auto& [i, axes] : rotated_) f[i] = axes.transpose() * f[i];
}

energy::Configuration Model::configuration(Vec a) {
  update_points(a, u_, x_);
  return {x_.data(), u_.data(), nullptr, energy::Tangent::exact};
}

void Model::element_forces(Vec a, Vec f) {
  const energy::Configuration c = configuration(a);
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  add_forces(membrane_, c);
  add_forces(curved_, c);
  fold_forces(force_);
  const petsc::WriteArray out(f);
  for (Index i = 0; i < owned_; ++i)
    for (int k = 0; k < 3; ++k) out[3 * i + k] += force_[i][k];
}

void Model::unbalanced_force(Vec a, Vec f) {
  VOILE_PETSC(MatMult(bending_.mat(), a, f));
  element_forces(a, f);
  if (contact_) contact_->add_gradient(a, f);
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  add_forces(followers_, {x_.data(), u_.data(), nullptr, energy::Tangent::exact});
  fold_forces(force_);
  // Applied forces collect in work_, so that their size is known.
  VOILE_PETSC(VecCopy(constant_, work_));
  VOILE_PETSC(VecAXPY(work_, load_factor_, dead_));
  {
    const petsc::WriteArray applied(work_);
    for (Index i = 0; i < owned_; ++i)
      for (int k = 0; k < 3; ++k) applied[3 * i + k] -= force_[i][k];
  }
  VOILE_PETSC(VecAXPY(f, -1.0, work_));
}

void Model::residual(Vec a, Vec r) {
  const petsc::EventScope scope(petsc::events().residual);
  unbalanced_force(a, r);
  double applied = 0.0, reaction = 0.0;
  VOILE_PETSC(VecNorm(work_, NORM_2, &applied));
  {
    const petsc::WriteArray out(r);
    const petsc::ReadArray unknown(a), prescribed(prescribed_), motion(motion_);
    for (PetscInt i : fixed_) {
      reaction += out[i] * out[i];
      out[i] = unknown[i] - load_factor_ * prescribed[i] - motion[i];
    }
  }
  force_scale_ = std::max(applied, std::sqrt(mpi::sum(comm_, reaction)));
}

Energies Model::energies(Vec a) {
  const std::vector<double> viscosity = membrane_.term.viscosity();
  membrane_.term.set_viscosity({});
  const Energies e = energies_of_step(a);
  membrane_.term.set_viscosity(viscosity);
  return e;
}

void Model::count_energy_from(Vec a) {
  VOILE_PETSC(VecCopy(a, reference_));
  VOILE_PETSC(MatMult(bending_.mat(), a, work_));
  VOILE_PETSC(VecDot(work_, a, &reference_bending_));
}

Energies Model::energies_of_step(Vec a) {
  const petsc::EventScope scope(petsc::events().energy);
  Energies e;
  const energy::Configuration c = configuration(a);
  double bending = 0.0, constant = 0.0, dead = 0.0;
  VOILE_PETSC(VecWAXPY(sum_, 1.0, reference_, a));
  VOILE_PETSC(MatMult(bending_.mat(), sum_, work_));
  VOILE_PETSC(VecWAXPY(sum_, -1.0, reference_, a));
  VOILE_PETSC(VecDot(work_, sum_, &bending));
  VOILE_PETSC(VecDot(constant_, a, &constant));
  VOILE_PETSC(VecDot(dead_, a, &dead));
  e.membrane = mpi::sum(comm_, owned_energy(membrane_, c));
  e.bending = 0.5 * (reference_bending_ + bending) + mpi::sum(comm_, owned_energy(curved_, c));
  e.springs = spring_energy(a);
  e.bending -= e.springs;  // they are part of the constant matrix
  e.external = -constant - load_factor_ * dead;
  if (contact_) e.contact = contact_->energy(a);
  return e;
}

double Model::energy(Vec a) {
  const Energies e = energies_of_step(a);
  return e.membrane + e.bending + e.springs + e.external + e.contact;
}

void Model::set_drag(const energy::DragOptions& options) {
  drag_.term = energy::DragTerm(options);
  velocity_.resize(point_of_.size());
  drag_force_.resize(point_of_.size());
  for (Index e = 0; options.active() && e < membrane_.term.size(); ++e) {
    const Index* p = membrane_.term.stencil(e);
    drag_.term.add({p[0], p[1], p[2]}, mesh_->area(membrane_triangle_[e]), membrane_.term.owned(e));
  }
  locate(drag_);
}

void Model::start_step(Vec a, Vec v, double viscosity, double inverse_step) {
  const energy::Configuration c = configuration(a);
  membrane_.term.start_step(c, viscosity, inverse_step);
  if (drag_.term.size() == 0) return;
  update_points(v, velocity_, drag_force_);  // the sum with rest positions is not used
  drag_.term.start_step(c.x, velocity_.data());
}

void Model::add_drag(Vec v, Vec f) {
  if (drag_.term.size() == 0) return;
  update_points(v, velocity_, drag_force_);
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  add_forces(drag_, {velocity_.data(), velocity_.data(), nullptr, energy::Tangent::exact});
  fold_forces(force_);
  const petsc::WriteArray out(f);
  for (Index i = 0; i < owned_; ++i)
    for (int k = 0; k < 3; ++k) out[3 * i + k] += force_[i][k];
}

double Model::drag_power(Vec v) {
  if (drag_.term.size() == 0) return 0.0;
  update_points(v, velocity_, drag_force_);
  return mpi::sum(comm_, owned_energy(drag_, {velocity_.data(), velocity_.data(), nullptr, energy::Tangent::exact}));
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
    if (BlockPattern pattern = bending_.pattern(); contact_->needs(a, tangent_, pattern))
      extend_tangent(std::move(pattern));
  energy::Configuration c = configuration(a);
  c.tangent = request.kind;
  if (request.previous) {
    update_points(request.previous, previous_u_, previous_x_);
    c.previous = previous_x_.data();
  }
  const BlockMatrix::Values values = tangent_.open();
  {
    const petsc::EventScope copy(petsc::events().bending_copy);
    tangent_.copy_values_from(bending_);
    if (request.bending != 1.0) tangent_.add_values_from(bending_, request.bending - 1.0);
    if (damping_ && request.damping > 0.0) tangent_.add_values_from(*damping_, request.damping);
  }
  add_blocks(membrane_, c, values);
  add_blocks(curved_, c, values);
  add_blocks(followers_, c, values);
  if (request.drag > 0.0) {
    drag_.term.set_scale(request.drag);
    add_blocks(drag_, c, values);
  }
  if (request.mass > 0.0 && request.mass_matrix) tangent_.add_values_from(*request.mass_matrix, request.mass);
  if (request.mass > 0.0 && !request.mass_matrix) {
    const petsc::ReadArray mass(mass_);
    for (Index i = 0; i < owned_; ++i)
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
  const auto axes = [&](Index i) {
    return rotated_index_[i] == no_index ? Mat3(Mat3::Identity()) : rotated_[rotated_index_[i]].second;
  };
  for (Index t = 0; t < mesh_->triangle_count(); ++t) {
    const double part = sheet_->material(t).areal_density * mesh_->area(t) / 12.0;
    for (Index v : mesh_->triangles()[t]) {
      const Index i = local_of_[v];
      if (i == no_index || i >= owned_) continue;
      for (Index w : mesh_->triangles()[t]) {
        const Index j = local_of_[w];
        values.add(mass.slot(i, row_of_local_[j]), (v == w ? 2.0 : 1.0) * part * axes(i).transpose() * axes(j));
      }
    }
  }
  for (const auto& [i, m] : masses_) values.add(mass.slot(i, partition_.owned_begin(rank_) + i), m * Mat3::Identity());
  eliminate(base_eliminated_, values);
  for (Index at : base_eliminated_.unit) values.diagonal[at] = 0.0;
  mass.close();
  return mass;
}

void Model::find_coupling(Vec a) {
  VOILE_PETSC(VecZeroEntries(work_));
  {
    const petsc::WriteArray off(work_);
    const petsc::ReadArray unknown(a), prescribed(prescribed_), motion(motion_);
    for (PetscInt i : fixed_) off[i] = unknown[i] - load_factor_ * prescribed[i] - motion[i];
  }
  double size = 0.0;
  VOILE_PETSC(VecNorm(work_, NORM_INFINITY, &size));
  if (size == 0.0) return;
  has_coupling_ = true;
  VOILE_PETSC(MatMult(tangent_.mat(), work_, coupling_));
  const petsc::WriteArray coupling(coupling_);
  for (PetscInt i : fixed_) coupling[i] = 0.0;
}

void Model::eliminate(const Eliminated& entries, const BlockMatrix::Values& values) {
  for (Index at : entries.diagonal) values.diagonal[at] = 0.0;
  for (Index at : entries.off_diagonal) values.off_diagonal[at] = 0.0;
  for (Index at : entries.unit) values.diagonal[at] = 1.0;
}

void Model::extend_tangent(BlockPattern pattern) {
  tangent_.extend(bending_, std::move(pattern));
  eliminated_ = find_eliminated_entries(tangent_);
  locate(membrane_);
  locate(curved_);
  locate(followers_);
  locate(drag_);
  for (Index i = 0; i < owned_; ++i) mass_slots_[i] = tangent_.slot(i, partition_.owned_begin(rank_) + i);
  ++pattern_version_;
}

void Model::load_direction(Vec a, Vec f) {
  VOILE_PETSC(VecCopy(dead_, f));
  if (any_follower_) {
    // Follower loads are linear in the load factor: a difference over one unit is exact.
    const energy::Configuration c = configuration(a);
    for (const double sign : {1.0, -1.0}) {
      followers_.term.set_factor(energy::FollowerTerm::load_factor, load_factor_ + (sign > 0.0 ? 1.0 : 0.0));
      std::fill(force_.begin(), force_.end(), Vec3::Zero());
      add_forces(followers_, c);
      fold_forces(force_);
      const petsc::WriteArray out(f);
      for (Index i = 0; i < owned_; ++i)
        for (int k = 0; k < 3; ++k) out[3 * i + k] -= sign * force_[i][k];
    }
  }
  if (has_prescribed_) VOILE_PETSC(VecAXPY(f, -1.0, load_coupling_));
  const petsc::ReadArray prescribed(prescribed_);
  const petsc::WriteArray out(f);
  for (PetscInt i : fixed_) out[i] = prescribed[i];
}

void Model::clear_fixed(Vec v) const {
  const petsc::WriteArray values(v);
  for (PetscInt i : fixed_) values[i] = 0.0;
}

void Model::clear_free(Vec v) const {
  const petsc::WriteArray values(v);
  PetscInt next = 0;
  for (PetscInt i : fixed_) {
    for (; next < i; ++next) values[next] = 0.0;
    next = i + 1;
  }
  for (; next < 3 * static_cast<PetscInt>(owned_); ++next) values[next] = 0.0;
}

std::vector<double> Model::gather(Vec a) const {
  std::vector<double> values(static_cast<std::size_t>(unknowns()), 0.0);
  {
    const petsc::ReadArray in(a);
    for (Index i = 0; i < owned_; ++i) {
      Vec3 u = Eigen::Map<const Vec3>(in.data() + 3 * i);
      if (rotated_index_[i] != no_index) u = rotated_[rotated_index_[i]].second * u;
      for (int k = 0; k < 3; ++k) values[3 * static_cast<std::size_t>(point_of_[i]) + k] = u[k];
    }
  }
  mpi::sum_to_root(comm_, values);
  if (rank_ != 0) values.clear();
  return values;
}

void Model::scatter(const std::vector<double>& values, Vec a) const {
  std::vector<double> all = values;
  mpi::broadcast(comm_, all);
  const petsc::WriteArray out(a);
  for (Index i = 0; i < owned_; ++i) {
    Vec3 u = Eigen::Map<const Vec3>(all.data() + 3 * point_of_[i]);
    if (rotated_index_[i] != no_index) u = rotated_[rotated_index_[i]].second.transpose() * u;
    for (int k = 0; k < 3; ++k) out[3 * i + k] = u[k];
  }
}

TriangleFields Model::triangle_fields(Vec a) {
  const auto size = 3 * static_cast<std::size_t>(mesh_->triangle_count());
  TriangleFields f;
  for (auto* v : {&f.membrane_strain, &f.membrane_force, &f.curvature, &f.bending_moment}) v->assign(size, 0.0);
  const energy::Configuration c = configuration(a);
  const auto store = [](std::vector<double>& to, Index t, const Vec3& value) {
    for (int k = 0; k < 3; ++k) to[3 * static_cast<std::size_t>(t) + k] = value[k];
  };
  for (Index e = 0; e < membrane_.term.size(); ++e) {
    if (!membrane_.term.owned(e)) continue;
    store(f.membrane_strain, membrane_triangle_[e], membrane_.term.strain(e, c));
    store(f.membrane_force, membrane_triangle_[e], membrane_.term.force(e, c));
  }
  for (const Recovery& r : recovery_) {
    const Index* p = recovery_points_.data() + r.start;
    const Vec3 edge = x_[p[1]] - x_[p[0]], normal = edge.cross(Vec3(x_[p[2]] - x_[p[0]])).normalized();
    const Vec3 rest_normal = mesh_->unit_normal(r.triangle);
    // n.k'(x) - kappa0 with k'(x) = kappa0 N + B'u.
    Vec3 kappa = (normal.dot(rest_normal) - 1.0) * r.rest_curvature;
    for (int i = 0; i < r.count; ++i) kappa += normal.dot(u_[p[i]]) * recovery_weights_[r.start + i];
    store(f.curvature, r.triangle, kappa);
    store(f.bending_moment, r.triangle, sheet_->material(r.triangle).bending * kappa);
  }
  for (auto* v : {&f.membrane_strain, &f.membrane_force, &f.curvature, &f.bending_moment}) {
    mpi::sum_to_root(comm_, *v);
    if (rank_ != 0) v->clear();
  }
  return f;
}

}  // namespace voile::system

#include "dofs.hpp"

#include "base/mpi.hpp"
#include "mesh/patch.hpp"

namespace voile::system {

Dofs::Dofs(MPI_Comm comm, const mesh::PatchMesh& patches, const mesh::Partition& partition,
           const Constraints& constraints, const std::vector<char>& needed)
    : comm_(comm),
      mesh_(constraints.ties.any() ? constraints.ties.mesh : &patches.mesh()),
      partition_(&partition),
      rank_(mpi::rank(comm)),
      first_row_(partition.owned_begin(rank_)),
      ties_(&constraints.ties) {
  number(patches, needed, constraints.turned_by);
  number_ties();
  number_bodies(patches, constraints, needed);
  take_constraints(constraints);
  create_scatter();
}

Mat3 Dofs::axes(Index v) const {
  return has_axes(v) ? axes_[axes_of_[v]] : Mat3(Mat3::Identity());
}

Vec3 Dofs::turned_to_own(Index v, const Vec3& f) const {
  return axes_[axes_of_[v]].transpose() * f;
}

Vec3 Dofs::turned_to_global(Index v, const Vec3& a) const {
  return axes_[axes_of_[v]] * a;
}

Vec3 Dofs::offset(Index point) const {
  return point < first_mirror_ ? Vec3(Vec3::Zero()) : mirrors_[point - first_mirror_].offset;
}

void Dofs::number(const mesh::PatchMesh& patches, const std::vector<char>& needed, const std::vector<int>& turned_by) {
  local_.local_of.assign(needed.size(), no_index);
  const auto append = [&](Index point) {
    local_.local_of[point] = local_.count();
    local_.point_of.push_back(point);
    local_.start.push_back(patches.start(point));
  };
  local_.owned = partition_->owned_count(rank_);
  for (Index r = 0; r < local_.owned; ++r) append(partition_->vertex_of[first_row_ + r]);
  for (Index v = 0; v < mesh_->vertex_count(); ++v)
    if (needed[v] && local_.local_of[v] == no_index) append(v);
  local_.vertices = local_.count();
  for (Index i = 0; i < local_.vertices; ++i) local_.row_of.push_back(partition_->row_of[local_.point_of[i]]);
  const Index vertices = patches.mesh().vertex_count();
  for (Index p = mesh_->vertex_count(); p < vertices; ++p)
    if (needed[p]) append(p);
  first_mirror_ = local_.count();
  for (Index p = vertices; p < patches.point_count(); ++p)
    if (needed[p]) {
      append(p);
      const mesh::MirrorPoint& m = patches.mirror(p);
      const auto number = static_cast<std::size_t>(p - vertices);
      const Vec3 foot = (1.0 - m.foot) * patches.start(m.a) + m.foot * patches.start(m.b);
      mirrors_.push_back({local_.local_of[m.apex], local_.local_of[m.a], local_.local_of[m.b], m.foot, m.reflection,
                          m.reflection, patches.start(m.apex) - foot, turned_by[number]});
    }
}

void Dofs::take_constraints(const Constraints& constraints) {
  axes_of_.assign(static_cast<std::size_t>(mesh_->vertex_count()), no_index);
  fixed_flags_.assign(3 * axes_of_.size(), 0);
  for (const auto& [v, support] : constraints.vertices) {
    for (int k = 0; k < 3; ++k) fixed_flags_[3 * static_cast<std::size_t>(v) + k] = support.fixed[k];
    if (!support.rotated()) continue;
    axes_of_[v] = static_cast<Index>(axes_.size());
    axes_.push_back(support.axes);
  }
  for (Index i = 0; i < local_.vertices; ++i) {
    if (has_axes(local_.point_of[i])) rotated_.push_back(i);
    for (int k = 0; k < 3 && i < local_.owned; ++k)
      if (is_fixed(local_.point_of[i], k)) fixed_.push_back(3 * i + k);
  }
}

void Dofs::create_scatter() {
  VOILE_PETSC(VecCreateMPI(comm_, 3 * local_.owned, PETSC_DETERMINE, pattern_.out()));
  VOILE_PETSC(VecSetBlockSize(pattern_, 3));
  VOILE_PETSC(VecCreateSeq(PETSC_COMM_SELF, 3 * local_.vertices, halo_.out()));
  petsc::IndexSetHandle from, to;
  VOILE_PETSC(ISCreateBlock(PETSC_COMM_SELF, 3, local_.vertices, local_.row_of.data(), PETSC_COPY_VALUES, from.out()));
  VOILE_PETSC(ISCreateStride(PETSC_COMM_SELF, 3 * local_.vertices, 0, 1, to.out()));
  VOILE_PETSC(VecScatterCreate(pattern_, from, halo_, to, scatter_.out()));
}

// ---- local points --------------------------------------------------------------------------------------------------

std::vector<Dofs::Share> Dofs::fractions(Index point) const {
  if (const Index b = body_of_point(point); b != no_index) return body_fractions(static_cast<std::size_t>(b), point);
  if (!tied_.empty()) return tied_fractions(point);
  const auto own_map = [&](Index vertex, const Mat3& map) -> Share {
    const Index v = local_.point_of[vertex];
    return {vertex, has_axes(v) ? Mat3(map * axes_[axes_of_[v]]) : map};
  };
  if (point < local_.vertices) return {own_map(point, Mat3::Identity())};
  const Mirror& g = mirrors_[point - first_mirror_];
  const Mat3 rest = Mat3::Identity() - g.reflection;
  return {own_map(g.apex, g.reflection), own_map(g.a, (1.0 - g.foot) * rest), own_map(g.b, g.foot * rest)};
}

void Dofs::turn_mirrors(const std::vector<Mat3>& rotation) {
  for (Mirror& g : mirrors_) {
    if (g.support < 0) continue;
    const Mat3& q = rotation[static_cast<std::size_t>(g.support)];
    g.reflection = q * g.rest_reflection * q.transpose();
    g.offset = (g.reflection - g.rest_reflection) * g.arm;
  }
}

void Dofs::take_halo(Vec a) const {
  VOILE_PETSC(VecScatterBegin(scatter_, a, halo_, INSERT_VALUES, SCATTER_FORWARD));
  VOILE_PETSC(VecScatterEnd(scatter_, a, halo_, INSERT_VALUES, SCATTER_FORWARD));
}

void Dofs::update_points(Vec a, std::vector<Vec3>& u, std::vector<Vec3>& x) const {
  take_halo(a);
  const petsc::ReadArray values(halo_);
  for (Index i = 0; i < local_.vertices; ++i) u[i] = Eigen::Map<const Vec3>(values.data() + 3 * i);
  for (Index i : rotated_) u[i] = axes_[axes_of_[local_.point_of[i]]] * u[i];
  for (const Tied& t : tied_) {
    u[t.point] = u[t.root];
    for (std::size_t i = 0; i < local_carriers_.size(); ++i)
      if (t.periods[i] != 0)
        u[t.point] += t.periods[i] * Eigen::Map<const Vec3>(values.data() + 3 * local_carriers_[i]);
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    set_motion(b, values);
    for (const BodyPoint& p : bodies_[b].points) u[p.point] = motions_[b].displacement() + motions_[b].turned() * p.arm;
  }
  for (std::size_t m = 0; m < mirrors_.size(); ++m) {
    const Mirror& g = mirrors_[m];
    const Vec3 foot = (1.0 - g.foot) * u[g.a] + g.foot * u[g.b];
    u[static_cast<std::size_t>(first_mirror_) + m] = foot + g.reflection * (u[g.apex] - foot) + g.offset;
  }
  for (std::size_t i = 0; i < u.size(); ++i) x[i] = local_.start[i] + u[i];
}

std::vector<Vec3> Dofs::point_changes(Vec da) const {
  take_halo(da);
  const petsc::ReadArray values(halo_);
  std::vector<Vec3> u(static_cast<std::size_t>(local_.count()), Vec3::Zero());
  for (Index i = 0; i < local_.count(); ++i)
    for (const Share& s : fractions(i)) u[i] += s.map * Eigen::Map<const Vec3>(values.data() + 3 * s.vertex);
  return u;
}

void Dofs::add_forces(std::vector<Vec3>& force, Vec f) const {
  for (std::size_t m = 0; m < mirrors_.size(); ++m) {
    const Mirror& g = mirrors_[m];
    const Vec3 on_mirror = force[static_cast<std::size_t>(first_mirror_) + m];
    const Vec3 mirrored = g.reflection.transpose() * on_mirror;
    force[g.apex] += mirrored;
    force[g.a] += (1.0 - g.foot) * (on_mirror - mirrored);
    force[g.b] += g.foot * (on_mirror - mirrored);
  }
  if (!tied_.empty()) add_tied_forces(force);
  for (Index i : rotated_) force[i] = to_own(local_.point_of[i], force[i]);
  const petsc::WriteArray out(f);
  const std::vector<BodyForce> on_bodies = body_forces(force);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    for (const BodyPoint& p : bodies_[b].points) force[p.point].setZero();
    add_body_force(b, on_bodies[b], out);
  }
  for (Index i = 0; i < local_.owned; ++i)
    for (int k = 0; k < 3; ++k) out[3 * i + k] += force[i][k];
}

// ---- vectors -------------------------------------------------------------------------------------------------------

petsc::VecHandle Dofs::create_vector() const {
  petsc::VecHandle v;
  VOILE_PETSC(VecDuplicate(pattern_, v.out()));
  VOILE_PETSC(VecZeroEntries(v));
  return v;
}

void Dofs::clear_fixed(Vec v) const {
  const petsc::WriteArray values(v);
  for (PetscInt i : fixed_) values[i] = 0.0;
}

void Dofs::clear_free(Vec v) const {
  const petsc::WriteArray values(v);
  PetscInt next = 0;
  for (PetscInt i : fixed_) {
    for (; next < i; ++next) values[next] = 0.0;
    next = i + 1;
  }
  for (; next < 3 * static_cast<PetscInt>(local_.owned); ++next) values[next] = 0.0;
}

std::vector<double> Dofs::gather_with(Vec a, const std::function<Vec3(Index local)>& of_body) const {
  std::vector<double> own;
  {
    const petsc::ReadArray in(a);
    for (Index i = 0; i < local_.owned; ++i) {
      const Index v = local_.point_of[i];
      const Vec3 u = is_dependent(v) ? of_body(i) : to_global(v, Eigen::Map<const Vec3>(in.data() + 3 * i));
      own.insert(own.end(), u.begin(), u.end());
    }
  }
  const std::vector<double> rows = mpi::gather_to_root(comm_, own);
  std::vector<double> values(rows.size());
  for (std::size_t row = 0; 3 * row < rows.size(); ++row)
    std::copy_n(&rows[3 * row], 3, &values[3 * static_cast<std::size_t>(partition_->vertex_of[row])]);
  return values;
}

void Dofs::scatter_with(const std::vector<double>& values, Vec a, bool on_bodies) const {
  std::vector<double> all = values;
  mpi::broadcast(comm_, all);
  if (ties_->any()) on_bodies ? take_tied_forces(all) : take_differences(all);
  const petsc::WriteArray out(a);
  for (Index i = 0; i < local_.owned; ++i) {
    const Index v = local_.point_of[i];
    const Vec3 own = !on_bodies && body_of(v) != no_index
                         ? Vec3(Vec3::Zero())
                         : to_own(v, Eigen::Map<const Vec3>(all.data() + 3 * static_cast<std::size_t>(v)));
    for (int k = 0; k < 3; ++k) out[3 * i + k] = own[k];
  }
}

void Dofs::place_vertex(Index i, const Vec3& x, const petsc::WriteArray& a) const {
  const Index v = local_.point_of[i];
  const Vec3 own = to_own(v, x - mesh_->positions()[v]);
  for (int k = 0; k < 3; ++k)
    if (!is_fixed(v, k)) a[3 * i + k] = own[k];
}

void set_positions(const Dofs& dofs, const std::vector<Vec3>& x, Vec a) {
  const petsc::WriteArray out(a);
  for (Index i = 0; i < dofs.local().owned; ++i) dofs.place_vertex(i, x[dofs.local().point_of[i]], out);
}

std::vector<Mat3> free_directions(const Dofs& dofs) {
  std::vector<Mat3> free(static_cast<std::size_t>(dofs.mesh().vertex_count()));
  for (Index v = 0; v < dofs.mesh().vertex_count(); ++v) {
    Vec3 keep;
    for (int k = 0; k < 3; ++k) keep[k] = dofs.is_fixed(v, k) ? 0.0 : 1.0;
    const Mat3 q = dofs.axes(v);
    free[v] = q * keep.asDiagonal() * q.transpose();
  }
  return free;
}

}  // namespace voile::system

#include "constant_matrices.hpp"

#include <algorithm>

#include "base/mpi.hpp"
#include "energy/sheet.hpp"
#include "term.hpp"

namespace voile::system {

ConstantMatrices::ConstantMatrices(const Discretisation& on, BlockPattern pattern, const std::vector<PointMass>& masses)
    : on_(&on), bending_(on.comm(), on.partition(), std::move(pattern)), mass_(on.dofs().create_vector()) {
  const std::vector<energy::Material>& materials = on.materials();
  if (std::any_of(materials.begin(), materials.end(), [](const auto& m) { return m.bending_damping > 0.0; }))
    damping_ = bending_.twin();
  mpi::on_all(on.comm(), [&] { lump(masses); });
}

void ConstantMatrices::lump(const std::vector<PointMass>& masses) {
  const petsc::WriteArray mass(mass_);
  const mesh::SurfaceMesh& mesh = on_->mesh();
  const Ties& ties = on_->constraints().ties;
  body_mass_.resize(on_->constraints().bodies.size());
  extra_body_mass_.resize(body_mass_.size());
  const auto add = [&](Index v, double m) {
    take_body_mass(v, m, body_mass_);
    const auto put = [&](Index at, double part) {
      const Index i = on_->owned(at);
      for (int k = 0; i != no_index && k < 3; ++k) mass[3 * i + k] += part;
      return i != no_index;
    };
    if (!ties.any()) return put(v, m);
    for (std::size_t p = 0; p < ties.carriers.size(); ++p)
      (void)put(ties.carriers[p], ties.periods(v, p) * ties.periods(v, p) * m);
    return put(ties.root(v), m);
  };
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const double area = mesh.area(t), density = on_->sheet().material(t).areal_density;
    for (Index v : mesh.triangles()[t]) (void)add(v, (density > 0.0 ? density : 1.0) * area / 3.0);
  }
  for (const PointMass& m : masses)
    for (const Index v : mesh.group(m.group).places()) {
      take_body_mass(v, m.mass, extra_body_mass_);
      if (add(v, m.mass) && !on_->is_on_body({v})) masses_.emplace_back(on_->owned(v), m.mass);
    }
  for (std::size_t b = 0; b < body_mass_.size(); ++b) {
    const double own = on_->constraints().bodies[b].mass;
    body_mass_[b].add(own, Vec3::Zero());
    extra_body_mass_[b].add(own, Vec3::Zero());
  }
  write_body_mass(mass);
}

void ConstantMatrices::take_body_mass(Index v, double m, std::vector<BodyMass>& of) const {
  const Index b = on_->dofs().body_of(v);
  if (b == no_index) return;
  const auto at = static_cast<std::size_t>(b);
  of[at].add(m, on_->mesh().positions()[v] - on_->constraints().bodies[at].point);
}

/// Where there is no mass, as of a straight edge that turns about itself, a small one weighs what the solvers compare.
void ConstantMatrices::write_body_mass(const petsc::WriteArray& mass) const {
  constexpr double small = 1e-3;
  const Dofs& dofs = on_->dofs();
  for (std::size_t b = 0; b < body_mass_.size(); ++b) {
    const RigidBody& body = on_->constraints().bodies[b];
    for (const Index v : body.members)
      for (int k = 0; k < 3; ++k)
        if (const Index i = on_->owned(v); i != no_index) mass[3 * i + k] = 0.0;
    const RigidMotion::Block m = RigidMotion(body).mass(body_mass_[b]);
    const std::array<Index, 3>& at = dofs.carriers(b);
    for (int k = 0; k < RigidMotion::Row::RowsAtCompileTime; ++k) {
      const Index i = at[static_cast<std::size_t>(k / 3)];
      if (i < dofs.local().owned) mass[3 * i + k % 3] = std::max(m(k, k), small * body_mass_[b].mass);
    }
  }
}

void ConstantMatrices::make_compact(bool keep) {
  compact_bending_.read(bending_);
  if (damping_) compact_damping_.read(*damping_);
  if (keep) return;
  bending_.release();
  if (damping_) damping_->release();
}

/// That of a triangle with vertices of rigid bodies, in the state taken last.
void ConstantMatrices::add_consistent(const BlockMatrix& mass, const BlockMatrix::Values& values,
                                      const mesh::Triangle& corners, double part) const {
  if (!on_->has_rows_of({corners[0], corners[1], corners[2]})) return;
  const std::vector<Index>& local_of = on_->dofs().local().local_of;
  for (const Index v : corners)
    for (const Index w : corners)
      add_block(on_->dofs(), mass, local_of[v], local_of[w], (v == w ? 2.0 : 1.0) * part * Mat3::Identity(), values);
}

BlockMatrix ConstantMatrices::consistent_mass() const {
  BlockMatrix mass = bending_.twin();
  const BlockMatrix::Values values = mass.open();
  const mesh::SurfaceMesh& mesh = on_->mesh();
  const Dofs& dofs = on_->dofs();
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const double part = on_->sheet().material(t).areal_density * mesh.area(t) / 12.0;
    const mesh::Triangle& corners = mesh.triangles()[t];
    if (std::any_of(corners.begin(), corners.end(), [&](Index v) { return dofs.is_dependent(v); })) {
      add_consistent(mass, values, corners, part);
      continue;
    }
    for (Index v : mesh.triangles()[t]) {
      const Index i = on_->owned(v);
      if (i == no_index) continue;
      for (Index w : mesh.triangles()[t])
        values.add(mass.slot(i, on_->partition().row_of[w]),
                   (v == w ? 2.0 : 1.0) * part * dofs.axes(v).transpose() * dofs.axes(w));
    }
  }
  for (const auto& [i, m] : masses_) values.add(mass.slot(i, dofs.first_row() + i), m * Mat3::Identity());
  for (std::size_t b = 0; b < extra_body_mass_.size(); ++b)
    dofs.add_unknowns_block(b, dofs.motions()[b].mass(extra_body_mass_[b]), mass, values);
  const Eliminated eliminated = find_eliminated(*on_, mass);
  eliminated.apply(values);
  for (Index at : eliminated.unit) values.diagonal[at] = 0.0;
  mass.close();
  return mass;
}

}  // namespace voile::system

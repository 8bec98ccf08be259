#include "constant_matrices.hpp"

#include <algorithm>

#include "base/mpi.hpp"
#include "energy/sheet.hpp"

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
  const auto add = [&](Index v, double m) {
    const Index i = on_->owned(v);
    if (i == no_index) return false;
    for (int k = 0; k < 3; ++k) mass[3 * i + k] += m;
    return true;
  };
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const double area = mesh.area(t), density = on_->sheet().material(t).areal_density;
    for (Index v : mesh.triangles()[t]) (void)add(v, (density > 0.0 ? density : 1.0) * area / 3.0);
  }
  for (const PointMass& m : masses)
    for (Index v : mesh.group(m.group).vertices)
      if (add(v, m.mass)) masses_.emplace_back(on_->owned(v), m.mass);
}

void ConstantMatrices::make_compact(bool keep) {
  compact_bending_.read(bending_);
  if (damping_) compact_damping_.read(*damping_);
  if (keep) return;
  bending_.release();
  if (damping_) damping_->release();
}

BlockMatrix ConstantMatrices::consistent_mass() const {
  BlockMatrix mass = bending_.twin();
  const BlockMatrix::Values values = mass.open();
  const mesh::SurfaceMesh& mesh = on_->mesh();
  const Dofs& dofs = on_->dofs();
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const double part = on_->sheet().material(t).areal_density * mesh.area(t) / 12.0;
    for (Index v : mesh.triangles()[t]) {
      const Index i = on_->owned(v);
      if (i == no_index) continue;
      for (Index w : mesh.triangles()[t])
        values.add(mass.slot(i, on_->partition().row_of[w]),
                   (v == w ? 2.0 : 1.0) * part * dofs.axes(v).transpose() * dofs.axes(w));
    }
  }
  for (const auto& [i, m] : masses_) values.add(mass.slot(i, dofs.first_row() + i), m * Mat3::Identity());
  const Eliminated eliminated = find_eliminated(*on_, mass);
  eliminated.apply(values);
  for (Index at : eliminated.unit) values.diagonal[at] = 0.0;
  mass.close();
  return mass;
}

}  // namespace voile::system

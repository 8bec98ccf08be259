#include "tangent.hpp"

namespace voile::system {

void Eliminated::apply(const BlockMatrix::Values& values) const {
  for (Index at : diagonal) values.diagonal[at] = 0.0;
  for (Index at : off_diagonal) values.off_diagonal[at] = 0.0;
  for (Index at : unit) values.diagonal[at] = 1.0;
}

Eliminated find_eliminated(const Discretisation& on, const BlockMatrix& matrix) {
  Eliminated e;
  std::vector<char> fixed(3 * static_cast<std::size_t>(on.mesh().vertex_count()), 0);
  for (const auto& [v, support] : on.constraints().vertices)
    for (int k = 0; k < 3; ++k) fixed[3 * on.partition().row_of[v] + k] = support.fixed[k];
  matrix.for_each_entry([&](bool inside, Index at, Index row, Index column) {
    if (!fixed[row] && !fixed[column]) return;
    if (row == column)
      e.unit.push_back(at);
    else
      (inside ? e.diagonal : e.off_diagonal).push_back(at);
  });
  return e;
}

Tangent::Tangent(const Discretisation& on, const BlockMatrix& base)
    : on_(&on),
      matrix_(base.twin()),
      eliminated_(find_eliminated(on, matrix_)),
      coupling_(on.dofs().create_vector()),
      load_coupling_(on.dofs().create_vector()) {
  for (Index i = 0; i < on.dofs().local().owned; ++i) mass_slots_.push_back(matrix_.slot(i, on.dofs().first_row() + i));
}

void Tangent::extend(const BlockMatrix& base, BlockPattern pattern) {
  matrix_.extend(base, std::move(pattern));
  eliminated_ = find_eliminated(*on_, matrix_);
  for (Index i = 0; i < on_->dofs().local().owned; ++i) mass_slots_[i] = matrix_.slot(i, on_->dofs().first_row() + i);
  ++pattern_version_;
}

void Tangent::add_mass(const BlockMatrix::Values& values, Vec mass, double factor) const {
  const petsc::ReadArray lumped(mass);
  for (Index i = 0; i < on_->dofs().local().owned; ++i)
    values.add(mass_slots_[i], Mat3(Eigen::Map<const Vec3>(lumped.data() + 3 * i).asDiagonal()) * factor);
}

void Tangent::close(const BlockMatrix::Values& values, Vec off, Vec prescribed) {
  has_coupling_ = false;
  if (!prescribed) {
    eliminated_.apply(values);
    matrix_.close();
    return;
  }
  matrix_.close();
  double size = 0.0;
  VOILE_PETSC(VecNorm(off, NORM_INFINITY, &size));
  if (size > 0.0) {
    has_coupling_ = true;
    VOILE_PETSC(MatMult(matrix_.mat(), off, coupling_));
    on_->dofs().clear_fixed(coupling_);
  }
  VOILE_PETSC(MatMult(matrix_.mat(), prescribed, load_coupling_));
  eliminated_.apply(matrix_.open());
  matrix_.close();
}

}  // namespace voile::system

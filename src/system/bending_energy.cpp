#include "bending_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/mpi.hpp"
#include "boundary_conditions.hpp"
#include "constant_matrices.hpp"
#include "energy/bending.hpp"
#include "energy/sheet.hpp"
#include "mesh/patch.hpp"
#include "term.hpp"
#include "voile/errors.hpp"

namespace voile::system {

BendingEnergy::BendingEnergy(Discretisation& on, ConstantMatrices& constant,
                             const std::vector<energy::CurvatureOperator>& curvatures,
                             const std::vector<Spring>& springs)
    : on_(&on), constant_(&constant), any_spring_(!springs.empty()) {
  const Dofs& dofs = on.dofs();
  for (petsc::VecHandle* v : {&reference_, &force_, &product_, &sum_, &steady_force_}) *v = dofs.create_vector();
  forces_.assign(static_cast<std::size_t>(dofs.local().count()), Vec3::Zero());
  const std::vector<int>& turned_by = on.constraints().turned_by;
  turns_ = std::any_of(turned_by.begin(), turned_by.end(), [](int support) { return support >= 0; });
  assemble(curvatures, springs);
  dofs.add_forces(forces_, steady_force_);
  VOILE_PETSC(VecCopy(steady_force_, force_));
  steady_offset_ = offset_ = mpi::sum(on.comm(), steady_offset_);
  count_from(reference_);
  if (!turns_) return;
  steady_ = constant.bending_blocks().twin();
  (void)steady_.open();
  steady_.copy_values_from(constant.bending_blocks());
  steady_.close();
  assemble_turning();
}

void BendingEnergy::force(Vec a, Vec f) const {
  constant_->multiply_bending(a, f);
  VOILE_PETSC(VecAXPY(f, 1.0, force_));
}

void BendingEnergy::count_from(Vec a) {
  VOILE_PETSC(VecCopy(a, reference_));
  constant_->multiply_bending(a, product_);
  VOILE_PETSC(VecAXPY(product_, 2.0, force_));
  VOILE_PETSC(VecDot(product_, a, &reference_energy_));
  reference_energy_ += offset_;
}

double BendingEnergy::energy(Vec a) const {
  double change = 0.0;
  VOILE_PETSC(VecWAXPY(sum_, 1.0, reference_, a));
  constant_->multiply_bending(sum_, product_);
  VOILE_PETSC(VecAXPY(product_, 2.0, force_));
  VOILE_PETSC(VecWAXPY(sum_, -1.0, reference_, a));
  VOILE_PETSC(VecDot(product_, sum_, &change));
  return 0.5 * (reference_energy_ + change);
}

void BendingEnergy::multiply_sheet(Vec x, Vec y) const {
  constant_->multiply_bending(x, y);
  if (springs_.empty()) return;
  const petsc::ReadArray in(x);
  const petsc::WriteArray out(y);
  for (const NodalSpring& s : springs_)
    Eigen::Map<Vec3>(&out[3 * s.vertex]) -= s.stiffness * Eigen::Map<const Vec3>(in.data() + 3 * s.vertex);
}

void BendingEnergy::take_springs_from(const BlockMatrix& tangent, const BlockMatrix::Values& values,
                                      double factor) const {
  for (const NodalSpring& s : springs_)
    values.add(tangent.slot(s.vertex, on_->dofs().first_row() + s.vertex), Mat3(-factor * s.stiffness));
}

double BendingEnergy::ground_energy(Vec a) const {
  if (!any_spring_) return 0.0;
  double sum = 0.0;
  const petsc::ReadArray u(a);
  for (const NodalSpring& s : springs_) {
    const Vec3 d = Eigen::Map<const Vec3>(u.data() + 3 * s.vertex);
    sum += 0.5 * d.dot(s.stiffness * d);
  }
  return mpi::sum(on_->comm(), sum);
}

void BendingEnergy::assemble(const std::vector<energy::CurvatureOperator>& curvatures,
                             const std::vector<Spring>& springs) {
  const petsc::EventScope scope(petsc::events().bending_assemble);
  const Dofs& dofs = on_->dofs();
  const std::vector<Index>& local_of = dofs.local().local_of;
  BlockMatrix& bending = constant_->bending_blocks();
  std::optional<BlockMatrix>& damped = constant_->damping_blocks();
  const BlockMatrix::Values values = bending.open();
  std::optional<BlockMatrix::Values> damping;
  if (damped) damping.emplace(damped->open());
  const auto is_turned = [&](Index p) {
    return on_->patches().is_mirror(p) && on_->constraints().turned_by[p - on_->patches().mesh().vertex_count()] >= 0;
  };
  mpi::on_all(on_->comm(), [&] {
    for (std::size_t k = 0; k < curvatures.size(); ++k) {
      const Discretisation::Element& item = on_->elements()[k];
      const energy::BendingElement el =
          energy::make_bending_element(on_->element_sheet(), item.triangle, curvatures[k]);
      std::vector<Index> points;
      for (Index p : el.points) points.push_back(local_of[p]);
      if (std::any_of(el.points.begin(), el.points.end(), is_turned)) {  // without damping of their own
        turning_.push_back({std::move(points), el.stiffness, el.start_force, item.owned});
        if (item.owned) steady_offset_ += 2.0 * el.start_energy;
        continue;
      }
      if (on_->is_on_body(el.points)) continue;  // a term of the potential
      take_start(el, item.owned);
      const double own_damping = on_->element_sheet().material(item.triangle).bending_damping;
      for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j < points.size(); ++j) {
          const Mat3 block =
              el.stiffness(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * Mat3::Identity();
          add_block(dofs, bending, points[i], points[j], block, values);
          if (own_damping > 0.0) add_block(dofs, *damped, points[i], points[j], own_damping * block, *damping);
        }
    }
    add_springs(springs, values);
  });
  bending.close();
  if (damped) damped->close();
  constant_->make_compact(turns_);
}

/// Collects what a bent start adds to the constant force and energy.
void BendingEnergy::take_start(const energy::BendingElement& element, bool owned) {
  for (Eigen::Index i = 0; i < element.start_force.rows(); ++i)
    forces_[on_->dofs().local().local_of[element.points[static_cast<std::size_t>(i)]]] +=
        element.start_force.row(i).transpose();
  if (owned) steady_offset_ += 2.0 * element.start_energy;
}

void BendingEnergy::add_springs(const std::vector<Spring>& springs, const BlockMatrix::Values& values) {
  for (const Spring& s : springs) {
    const Mat3 unit =
        s.direction ? Mat3(s.direction->normalized() * s.direction->normalized().transpose()) : Mat3(Mat3::Identity());
    const auto add = [&](Index v, double stiffness) {
      if (on_->is_on_body({v}))
        throw UserError(
            fmt::format("[[spring]] {}: vertex {} belongs to a [[rigid]] group, which has no springs to the ground; "
                        "name a `group` without those vertices, or hold the reference point by a `translation`",
                        s.group.empty() ? "on the whole surface" : fmt::format("group '{}'", s.group),
                        on_->mesh().data().vertex_tags[v]));
      // What a periodic sheet is held to repeats itself with it: differences along the springs are zero (case_periodic.cpp).
      const Ties& ties = on_->constraints().ties;
      const Index of = ties.any() ? ties.root(v) : v;
      const Index i = on_->owned(of);
      if (i == no_index) return;
      const Mat3 q = on_->dofs().axes(of);
      springs_.push_back({i, stiffness * q.transpose() * unit * q});
      values.add(constant_->bending_blocks().slot(i, on_->dofs().first_row() + i), springs_.back().stiffness);
    };
    const auto spread_over = [&](Load::Kind kind) {  // the same lumping as that of loads
      Load like;
      like.kind = kind;
      like.group = s.group;
      like.vector = s.stiffness * Vec3::UnitX();
      spread(*on_, like, [&](Index v, const Vec3& fraction) { add(v, fraction.x()); });
    };
    if (s.kind == Spring::Kind::point) spread_over(Load::Kind::point);
    if (s.kind == Spring::Kind::line) spread_over(Load::Kind::line);
    if (s.kind == Spring::Kind::area) spread_over(Load::Kind::area);
  }
}

void BendingEnergy::turn(const std::vector<Mat3>& rotations) {
  if (!turns_ || rotations == turns_now_) return;
  turns_now_ = rotations;
  on_->turn_mirrors(turns_now_);
  assemble_turning();
}

void BendingEnergy::assemble_turning() {
  const petsc::EventScope scope(petsc::events().bending_assemble);
  BlockMatrix& bending = constant_->bending_blocks();
  const BlockMatrix::Values values = bending.open();
  bending.copy_values_from(steady_);
  std::fill(forces_.begin(), forces_.end(), Vec3::Zero());
  double twice = 0.0;
  for (const TurningElement& e : turning_)
    for (std::size_t i = 0; i < e.points.size(); ++i)
      for (std::size_t j = 0; j < e.points.size(); ++j) {
        const double k = e.stiffness(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        add_block(on_->dofs(), bending, e.points[i], e.points[j], k * Mat3::Identity(), values);
        const Vec3 force = k * on_->dofs().offset(e.points[j]);
        forces_[e.points[i]] += force;
        if (e.owned) twice += force.dot(on_->dofs().offset(e.points[i]));
      }
  for (const TurningElement& e : turning_)
    for (Eigen::Index i = 0; i < e.start_force.rows(); ++i) {
      const Index p = e.points[static_cast<std::size_t>(i)];
      const Vec3 force = e.start_force.row(i).transpose();
      forces_[p] += force;
      if (e.owned) twice += 2.0 * force.dot(on_->dofs().offset(p));
    }
  bending.close();
  constant_->make_compact(true);
  VOILE_PETSC(VecCopy(steady_force_, force_));
  on_->dofs().add_forces(forces_, force_);
  offset_ = steady_offset_ + mpi::sum(on_->comm(), twice);
  count_from(reference_);
}

}  // namespace voile::system

// How supports move: their motions and turns in time, rates of these, and what a later stage takes hold of.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "boundary_conditions.hpp"

namespace voile::system {

void BoundaryConditions::move_supports(double time) {
  for (std::size_t i = 0; i < supports_.size(); ++i)
    if (supports_[i].rotation) rotations_[i] = supports_[i].rotation(time);
  if (movers_.empty() && !rigid_.moves()) return;
  const petsc::WriteArray motion(motion_);
  rigid_.move(time, motion);
  const LocalPoints& local = on_->dofs().local();
  Vec3 own = Vec3::Zero();  // of the vertex and support of the mover before, which most have in common
  Mover last{no_index, 0, -1, Vec3::Zero()};
  for (const Mover& m : movers_) {
    if (supports_[static_cast<std::size_t>(m.support)].follows) continue;
    const Support& support = supports_[static_cast<std::size_t>(m.support)];
    if (m.local != last.local || m.support != last.support)
      own = on_->dofs().to_own(local.point_of[m.local],
                               Vec3(m.rest - local.start[m.local] + support.motion(m.rest, time)));
    motion[3 * m.local + m.component] = own[m.component];
    last = m;
  }
}

double BoundaryConditions::turn_between(double from, double to, bool by_load) const {
  // A turn and back again, or by 360 degrees, is a turn.
  constexpr int parts = 16;
  double largest = 0.0;
  if (by_load != motion_by_load_) return largest;
  for (const Support& s : supports_) {
    if (!s.rotation) continue;
    double angle = 0.0;
    Mat3 before = s.rotation(from);
    for (int k = 1; k <= parts; ++k) {
      const Mat3 now = s.rotation(from + (to - from) * k / parts);
      angle += Eigen::AngleAxisd(before.transpose() * now).angle();
      before = now;
    }
    largest = std::max(largest, angle);
  }
  return std::max(largest, rigid_.turn_between(from, to));
}

void BoundaryConditions::prescribe_acceleration(const MotionTime& when, const std::function<double(double)>& factor,
                                                Vec acceleration) {
  const double before = when.time, after = when.end - when.time;
  const bool central = std::min(before, after) >= when.step;
  const int side = before > after ? -1 : 1;
  // Differences to one side are eleven times as far off at the same step.
  const double step = central ? when.step : std::min(0.1 * when.step, std::max(before, after) / 3.0);
  // The last restores the time in force.
  const std::vector<std::pair<int, double>> stencil =
      central ? std::vector<std::pair<int, double>>{{-1, 1.0}, {1, 1.0}, {0, -2.0}}
              : std::vector<std::pair<int, double>>{{3 * side, -1.0}, {2 * side, 4.0}, {side, -5.0}, {0, 2.0}};
  const petsc::WriteArray values(acceleration);
  for (PetscInt i : on_->dofs().fixed()) values[i] = 0.0;
  add_differences_in_time(stencil, when.time, step, factor, values);
  for (const PetscInt i : led_) values[i] /= step * step;
}

void BoundaryConditions::prescribe_velocity(const MotionTime& when, bool from_here,
                                            const std::function<double(double)>& factor, Vec velocity) {
  const double step = 1e-3 * when.step;  // before a corner at the time itself
  const int side = from_here || when.time < 2.0 * step ? 1 : -1;
  const petsc::WriteArray values(velocity);
  for (const PetscInt i : led_) values[i] = 0.0;
  add_differences_in_time({{2 * side, -1.0}, {side, 4.0}, {0, -3.0}}, when.time, step, factor, values);
  for (const PetscInt i : led_) values[i] /= 2.0 * side * step;
}

void BoundaryConditions::add_differences_in_time(const std::vector<std::pair<int, double>>& weights, double time,
                                                 double step, const std::function<double(double)>& factor,
                                                 const petsc::WriteArray& to) {
  if (!has_prescribed_) return;
  for (const auto& [k, weight] : weights) {
    const double at = time + k * step;
    move_supports(at);
    const petsc::ReadArray prescribed(prescribed_), motion(motion_);
    for (const PetscInt i : led_) to[i] += weight * (factor(at) * prescribed[i] + motion[i]);
  }
}

/// Motions are counted from where each vertex would have to come from to be where it is: X with X + u(X, t) = x. They are affine in X.
void BoundaryConditions::rebase_motions(Vec a, double time, double load_factor) {
  struct Affine {
    Mat3 map;
    Vec3 offset;
  };
  std::map<int, Affine> at;
  const petsc::ReadArray unknown(a), prescribed(prescribed_);
  const LocalPoints& local = on_->dofs().local();
  for (Mover& m : movers_) {
    const Support& support = supports_[static_cast<std::size_t>(m.support)];
    if (support.follows) continue;
    const auto [found, is_new] = at.try_emplace(m.support);
    Affine& f = found->second;
    if (is_new) {
      f.offset = support.motion(Vec3::Zero(), time);
      for (int k = 0; k < 3; ++k) f.map.col(k) = Vec3::Unit(k) + support.motion(Vec3::Unit(k), time) - f.offset;
    }
    const Index v = local.point_of[m.local];
    Vec3 own;
    for (int k = 0; k < 3; ++k) own[k] = unknown[3 * m.local + k] - load_factor * prescribed[3 * m.local + k];
    const Vec3 u = on_->dofs().to_global(v, own);
    m.rest = f.map.inverse() * (local.start[m.local] + u - f.offset);
  }
}

void BoundaryConditions::take_hold(Vec a, double time, double load_factor) {
  rebase_motions(a, time, load_factor);
  move_supports(time);
  const petsc::ReadArray unknown(a), prescribed(prescribed_), motion(motion_);
  const petsc::WriteArray hold(hold_);
  for (PetscInt i : on_->dofs().fixed()) hold[i] = unknown[i] - load_factor * prescribed[i] - motion[i];
}

}  // namespace voile::system

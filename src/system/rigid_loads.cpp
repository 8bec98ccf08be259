#include "rigid_loads.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/mpi.hpp"

namespace voile::system {

namespace {

using Turn = RigidGroup::Turn;

bool may_turn(const RigidGroup& g) {
  return g.turn == Turn::free || (g.turn == Turn::about && !g.angle);
}

}  // namespace

RigidLoads::RigidLoads(const Discretisation& on, std::vector<RigidGroup> groups)
    : on_(&on), groups_(std::move(groups)) {}

bool RigidLoads::moves() const {
  return std::any_of(groups_.begin(), groups_.end(), [](const RigidGroup& g) { return g.motion || g.angle; });
}

bool RigidLoads::symmetric() const {
  return std::none_of(groups_.begin(), groups_.end(),
                      [](const RigidGroup& g) { return g.turn == Turn::free && g.moment.squaredNorm() > 0.0; });
}

std::vector<BodyForce> RigidLoads::forces(bool constant) const {
  std::vector<BodyForce> all(groups_.size());
  for (std::size_t i = 0; i < groups_.size(); ++i)
    if (groups_[i].constant == constant) all[i].force = groups_[i].force;
  return all;
}

std::vector<BodyForce> RigidLoads::take(Vec force) const {
  constexpr std::size_t numbers = 12;
  std::vector<BodyForce> all(groups_.size());
  if (groups_.empty()) return all;
  {
    const petsc::WriteArray f(force);
    const LocalPoints& local = dofs().local();
    for (Index i = 0; i < local.owned; ++i) {
      const Index v = local.point_of[i], b = dofs().body_of(v);
      if (b == no_index) continue;
      const auto at = static_cast<std::size_t>(b);
      all[at].add(Vec3(f[3 * i], f[3 * i + 1], f[3 * i + 2]), local.start[i] - body(at).point);
      for (int k = 0; k < 3; ++k) f[3 * i + k] = 0.0;
    }
  }
  std::vector<double> flat(numbers * all.size());
  for (std::size_t b = 0; b < all.size(); ++b) {
    std::copy_n(all[b].force.data(), 3, flat.data() + numbers * b);
    std::copy_n(all[b].moments.data(), 9, flat.data() + numbers * b + 3);
  }
  mpi::sum_to_root(dofs().comm(), flat);
  mpi::broadcast(dofs().comm(), flat);
  for (std::size_t b = 0; b < all.size(); ++b) {
    all[b].force = Eigen::Map<const Vec3>(&flat[numbers * b]);
    all[b].moments = Eigen::Map<const Mat3>(&flat[numbers * b + 3]);
  }
  return all;
}

void RigidLoads::move(double time, const petsc::WriteArray& unknowns) const {
  for (std::size_t b = 0; b < groups_.size(); ++b) {
    const RigidGroup& g = groups_[b];
    const std::array<Index, 3>& at = dofs().carriers(b);
    const auto write = [&](std::size_t carrier, const Vec3& values, const std::array<bool, 3>& which) {
      for (int k = 0; k < 3; ++k)
        if (at[carrier] < dofs().local().owned && which[static_cast<std::size_t>(k)])
          unknowns[3 * at[carrier] + k] = values[k];
    };
    const auto since = [&](const auto& f) {
      return g.place.time ? decltype(f(time))(f(time) - f(*g.place.time)) : f(time);
    };
    if (g.motion) write(0, since(g.motion), g.held);
    if (!g.angle) continue;
    const auto turned = RigidMotion(body(b)).unknowns_of(g.axis->normalized(), since(g.angle));
    write(1, turned[0], {true, true, true});
    write(2, turned[1], {true, true, true});
  }
}

std::optional<Vec3> RigidLoads::prescribed_turn(std::size_t b, double time) const {
  const RigidGroup& g = groups_[b];
  if (!g.angle) return {};
  const Vec3 axis = g.axis->normalized();
  if (!g.place.time) return Vec3(g.angle(time) * axis);
  constexpr double same = 1e-9, turn = 4.0 * std::numbers::pi;
  const Vec3 before = RigidMotion(body(b)).rotation_vector();
  if (before.cross(axis).norm() > same) return {};
  // A motion that has gone on from the stage before counts its turns from its own start.
  const double start = g.angle(*g.place.time), apart = std::abs(std::remainder(start - before.dot(axis), turn));
  return Vec3((apart < same ? g.angle(time) : before.dot(axis) + g.angle(time) - start) * axis);
}

double RigidLoads::turn_between(double from, double to) const {
  constexpr int parts = 16;  // a turn and back again is a turn
  double largest = 0.0;
  for (const RigidGroup& g : groups_) {
    if (!g.angle) continue;
    double sum = 0.0, before = g.angle(from);
    for (int k = 1; k <= parts; ++k) {
      const double now = g.angle(from + (to - from) * k / parts);
      sum += std::abs(now - before);
      before = now;
    }
    largest = std::max(largest, sum);
  }
  return largest;
}

void RigidLoads::add(const std::vector<BodyForce>& on, Vec f) const {
  if (groups_.empty()) return;
  const petsc::WriteArray out(f);
  for (std::size_t b = 0; b < groups_.size(); ++b) dofs().add_body_force(b, on[b], out);
}

void RigidLoads::add_moments(double load_factor, bool constant, Vec f) const {
  if (groups_.empty()) return;
  const petsc::WriteArray out(f);
  for (std::size_t b = 0; b < groups_.size(); ++b)
    if (constant || !groups_[b].constant)
      dofs().add_turning_force(b, dofs().motions()[b].spin().transpose() * moment(b, load_factor), out);
}

double RigidLoads::potential(const std::vector<BodyForce>& on, double load_factor) const {
  double sum = 0.0;
  for (std::size_t b = 0; b < groups_.size(); ++b) {
    const RigidMotion& m = dofs().motions()[b];
    sum -= on[b].force.dot(m.displacement()) + m.turned().cwiseProduct(on[b].moments).sum();
    if (may_turn(groups_[b])) sum -= moment(b, load_factor).dot(m.turn_in_stage());
  }
  return sum;
}

void RigidLoads::add_blocks(const std::vector<BodyForce>& total, std::optional<double> load_factor,
                            const BlockMatrix& tangent, const BlockMatrix::Values& values) const {
  for (std::size_t b = 0; b < groups_.size(); ++b) {
    const RigidMotion& m = dofs().motions()[b];
    Eigen::Matrix4d k = m.length_tangent();
    if (load_factor && may_turn(groups_[b])) k -= m.moment_slope(moment(b, *load_factor));
    for (int i = 0; i < RigidMotion::turns; ++i)
      for (int j = 0; j < RigidMotion::turns; ++j) k(i, j) += m.curvature(i, j).cwiseProduct(total[b].moments).sum();
    RigidMotion::Block all = RigidMotion::Block::Zero();
    all.bottomRightCorner<4, 4>() = k;
    dofs().add_unknowns_block(b, all, tangent, values);
  }
}

std::vector<double> rigid_values(const Discretisation& on, Vec a, Vec f, bool linear) {
  const std::vector<double> unknowns = on.dofs().gather_bodies(a), forces = on.dofs().gather_bodies(f);
  const std::vector<RigidBody>& bodies = on.constraints().bodies;
  constexpr std::size_t each = 9;
  std::vector<double> all;
  for (std::size_t b = 0; each * b < unknowns.size(); ++b) {
    const double *u = &unknowns[each * b], *q = &forces[each * b];
    const auto three = [](const double* x) { return Vec3(Eigen::Map<const Vec3>(x)); };
    RigidMotion motion(bodies[b]);
    if (!linear) motion.set(three(u), three(u + 3), three(u + 6));
    const Eigen::Matrix<double, 3, RigidMotion::turns> spin = motion.spin();
    const Vec3 turn = linear ? Vec3(spin * Eigen::Vector4d(u[3], u[4], u[5], u[6])) : motion.rotation_vector();
    const Vec3 moment = (spin * spin.transpose()).ldlt().solve(spin * Eigen::Vector4d(q[3], q[4], q[5], q[6]));
    const Vec3 way = linear ? three(u) : motion.displacement();
    for (const Vec3& part : {way, turn, three(q), moment}) all.insert(all.end(), part.data(), part.data() + 3);
  }
  return all;
}

}  // namespace voile::system

#include "joint.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <utility>

namespace voile::energy {

void JointTerm::add(JointElement element, std::vector<Index> local, bool owned) {
  const auto count = static_cast<Eigen::Index>(element.angles.size());
  for (Eigen::Index n = 0; n < count; ++n) {
    const JointElement::Angle& a = element.angles[static_cast<std::size_t>(n)];
    angles_of_[a.triangle].emplace_back(size(), n);
    if (a.joint != no_index) at_joint_[a.joint].emplace_back(size(), n);
  }
  items_.push_back(
      {std::move(element), std::move(local), owned, Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count)});
}

std::vector<Index> JointTerm::triangles() const {
  std::vector<Index> all;
  for (const auto& entry : angles_of_) all.push_back(entry.first);
  return all;
}

void JointTerm::set_natural(Index triangle, const Vec3& curvature) {
  for (const auto& [e, n] : angles_of_.at(triangle))
    items_[e].natural[n] = items_[e].of.angles[static_cast<std::size_t>(n)].natural.dot(curvature);
}

void JointTerm::set_fold(Index joint, double angle) {
  for (const auto& [e, n] : at_joint_.at(joint))
    items_[e].folds[n] = items_[e].of.angles[static_cast<std::size_t>(n)].fold * angle;
}

double JointTerm::squared_fold_moment() const {
  double sum = 0.0;
  for (const Item& item : items_)
    if (item.owned) sum += (item.of.stiffness * item.folds).squaredNorm();
  return sum;
}

EdgePoints JointTerm::points_of(const JointElement::Angle& a, const Eigen::MatrixX3d& z) {
  return {Vec3::Zero(), z.row(a.edge), z.row(a.reference), z.row(a.vector)};
}

Eigen::MatrixX3d JointTerm::vectors(Index e, const Configuration& c) const {
  const Item& item = items_[e];
  Eigen::MatrixX3d u(static_cast<Eigen::Index>(item.local.size()), 3);
  for (std::size_t i = 0; i < item.local.size(); ++i) u.row(static_cast<Eigen::Index>(i)) = c.u[item.local[i]];
  return item.of.start + item.of.weights * u;
}

Eigen::VectorXd JointTerm::angles_of(Index e, const Eigen::MatrixX3d& z) const {
  const Item& item = items_[e];
  Eigen::VectorXd psi = item.natural + item.folds;
  for (std::size_t n = 0; n < item.of.angles.size(); ++n) {
    const JointElement::Angle& a = item.of.angles[n];
    if (a.vector != a.reference)
      psi[static_cast<Eigen::Index>(n)] += std::remainder(edge_angle(points_of(a, z)) - a.rest, 2.0 * std::numbers::pi);
  }
  return psi;
}

Eigen::VectorXd JointTerm::angles(Index e, const Configuration& c) const {
  return angles_of(e, vectors(e, c));
}

double JointTerm::energy(Index e, const Configuration& c) const {
  const Eigen::VectorXd psi = angles(e, c);
  return 0.5 * psi.dot(items_[e].of.stiffness * psi);
}

Eigen::MatrixX3d JointTerm::forces(Index e, const Configuration& c) const {
  const JointElement& of = items_[e].of;
  const Eigen::MatrixX3d z = vectors(e, c);
  const Eigen::VectorXd moment = of.stiffness * angles_of(e, z);
  Eigen::MatrixX3d by_vector = Eigen::MatrixX3d::Zero(z.rows(), 3);
  for (std::size_t n = 0; n < of.angles.size(); ++n) {
    const JointElement::Angle& a = of.angles[n];
    if (a.vector == a.reference) continue;
    const EdgePoints slopes = edge_angle_slopes(points_of(a, z));
    const double m = moment[static_cast<Eigen::Index>(n)];
    by_vector.row(a.edge) += m * slopes[1];
    by_vector.row(a.reference) += m * slopes[2];
    by_vector.row(a.vector) += m * slopes[3];
  }
  return of.weights.transpose() * by_vector;
}

Eigen::MatrixXd JointTerm::tangent(Index e, const Configuration& c) const {
  const JointElement& of = items_[e].of;
  const Eigen::MatrixX3d z = vectors(e, c);
  const Eigen::VectorXd moment = of.stiffness * angles_of(e, z);
  const auto count = static_cast<Eigen::Index>(of.angles.size()), points = of.weights.cols();
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(count, 3 * z.rows()),
                  by_vector = Eigen::MatrixXd::Zero(3 * z.rows(), 3 * z.rows());
  for (Eigen::Index n = 0; n < count; ++n) {
    const JointElement::Angle& a = of.angles[static_cast<std::size_t>(n)];
    if (a.vector == a.reference) continue;
    const EdgePoints x = points_of(a, z), first = edge_angle_slopes(x);
    const std::array<int, 3> rows{a.edge, a.reference, a.vector};
    for (std::size_t i = 0; i < 3; ++i) slopes.block<1, 3>(n, 3 * rows[i]) += first[i + 1].transpose();
    // Without second derivatives of angles the tangent is positive semidefinite.
    if (c.tangent == Tangent::positive) continue;
    const EdgeAngleCurvature second = edge_angle_curvature(x);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        by_vector.block<3, 3>(3 * rows[i], 3 * rows[j]) += moment[n] * second[i + 1][j + 1];
  }
  by_vector += slopes.transpose() * of.stiffness * slopes;
  Eigen::MatrixXd half(3 * z.rows(), 3 * points), blocks(3 * points, 3 * points);
  const auto spread = [&](const Eigen::MatrixXd& from, Eigen::MatrixXd& to) {  // columns of vectors to those of points
    to.setZero();
    for (Eigen::Index p = 0; p < points; ++p)
      for (Eigen::Index v = 0; v < z.rows(); ++v)
        if (of.weights(v, p) != 0.0) to.middleCols<3>(3 * p) += of.weights(v, p) * from.middleCols<3>(3 * v);
  };
  spread(by_vector, half);
  spread(half.transpose(), blocks);
  return blocks;
}

}  // namespace voile::energy

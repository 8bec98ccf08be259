#include "voile/energy/edge_angle.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "voile/base/cross_matrix.hpp"

namespace voile::energy {

namespace {

/// What the angle is made of.
struct Edge {
  Vec3 e, p, q, normal_p, normal_q;
  double length;

  explicit Edge(const EdgePoints& x)
      : e(x[1] - x[0]), p(x[2] - x[0]), q(x[3] - x[0]), normal_p(e.cross(p)), normal_q(q.cross(e)), length(e.norm()) {}
  [[nodiscard]] double foot(const Vec3& point) const { return point.dot(e) / (length * length); }
  [[nodiscard]] Vec3 slope(const Vec3& normal) const { return length / normal.squaredNorm() * normal; }
  /// Derivative of slope() by its normal.
  [[nodiscard]] Mat3 slope_by(const Vec3& normal) const {
    const double square = normal.squaredNorm();
    return length / square * (Mat3::Identity() - 2.0 / square * normal * normal.transpose());
  }
};

}  // namespace

double edge_angle(const EdgePoints& x) {
  const Edge edge(x);
  return std::atan2(edge.e.dot(edge.normal_q.cross(edge.normal_p)) / edge.length, edge.normal_p.dot(edge.normal_q));
}

EdgePoints edge_angle_slopes(const EdgePoints& x) {
  const Edge edge(x);
  const Vec3 by_p = edge.slope(edge.normal_p), by_q = edge.slope(edge.normal_q);
  const Vec3 by_b = -edge.foot(edge.p) * by_p - edge.foot(edge.q) * by_q;
  return {-by_b - by_p - by_q, by_b, by_p, by_q};
}

EdgeAngleCurvature edge_angle_curvature(const EdgePoints& x) {
  const Edge edge(x);
  const Vec3 by_p = edge.slope(edge.normal_p), by_q = edge.slope(edge.normal_q), along = edge.e / edge.length;
  const Mat3 by_normal_p = edge.slope_by(edge.normal_p), by_normal_q = edge.slope_by(edge.normal_q);
  const double foot_p = edge.foot(edge.p), foot_q = edge.foot(edge.q);
  // n_p = e x P and n_q = Q x e; the slopes also grow with l.
  const Mat3 pe = by_p * along.transpose() / edge.length - by_normal_p * cross_matrix(edge.p),
             qe = by_q * along.transpose() / edge.length + by_normal_q * cross_matrix(edge.q);
  const auto foot_slope = [&](const Vec3& point, double foot) -> Vec3 {
    return (point - 2.0 * foot * edge.e) / (edge.length * edge.length);
  };
  EdgeAngleCurvature c;
  c[1][1] = -by_p * foot_slope(edge.p, foot_p).transpose() - foot_p * pe -
            by_q * foot_slope(edge.q, foot_q).transpose() - foot_q * qe;
  c[2][1] = pe;
  c[3][1] = qe;
  c[1][2] = pe.transpose();
  c[1][3] = qe.transpose();
  c[2][2] = by_normal_p * cross_matrix(edge.e);
  c[3][3] = -by_normal_q * cross_matrix(edge.e);
  c[2][3].setZero();
  c[3][2].setZero();
  for (std::size_t k = 1; k < 4; ++k) {
    c[0][k] = -c[1][k] - c[2][k] - c[3][k];
    c[k][0] = c[0][k].transpose();
  }
  c[0][0] = -c[1][0] - c[2][0] - c[3][0];
  return c;
}

}  // namespace voile::energy

#include "slope_error.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

namespace voile::energy {

namespace {

Mat2 tensor(const Vec3& curvature) {
  Mat2 k;
  k << curvature[0], 0.5 * curvature[2], 0.5 * curvature[2], curvature[1];
  return k;
}

/// From corner k + 1 to corner k + 2.
std::array<Vec2, 3> sides_of(const std::array<Vec2, 3>& corners) {
  return {corners[2] - corners[1], corners[0] - corners[2], corners[1] - corners[0]};
}

}  // namespace

double excess_of_slopes(const std::array<Vec2, 3>& corners, const Vec3& force, const Vec3& curvature) {
  const std::array<Vec2, 3> e = sides_of(corners);
  const Mat2 k = tensor(curvature);
  Mat3 dyads;
  Vec3 strain;
  for (std::size_t s = 0; s < 3; ++s) {
    const Vec2 &a = e[s], &b = e[(s + 1) % 3], &c = e[(s + 2) % 3];
    dyads.col(static_cast<Eigen::Index>(s)) = Vec3(a[0] * a[0], a[1] * a[1], a[0] * a[1]);
    strain[static_cast<Eigen::Index>(s)] = std::pow(std::min(std::abs(a.dot(k * b)), std::abs(a.dot(k * c))), 2) / 12.0;
  }
  return (dyads.inverse() * force).dot(strain);
}

double excess_of_mass(const std::array<Vec2, 3>& corners, const std::array<Vec3, 3>& displacements, const Vec3& normal,
                      const Vec3& curvature, bool lumped) {
  const std::array<Vec2, 3> e = sides_of(corners);
  const Mat2 k = tensor(curvature);
  const auto& u = displacements;
  const Vec3 w(normal.dot(u[0]), normal.dot(u[1]), normal.dot(u[2]));
  Vec3 q;
  double squares = 0.0, apart = 0.0;
  for (std::size_t s = 0; s < 3; ++s) {
    q[static_cast<Eigen::Index>(s)] = e[s].dot(k * e[s]);
    squares += q[static_cast<Eigen::Index>(s)] * q[static_cast<Eigen::Index>(s)];
    apart += (u[(s + 1) % 3] - u[(s + 2) % 3]).squaredNorm();
  }
  // Means of L_i L_j times L_i, L_k; of its square and of L_i^2 L_j L_k: 1/30, 1/60; 1/90, 1/180.
  const double across = q.dot(Vec3::Constant(w.sum() / 30.0) - w / 60.0),
               bubble = (squares + q.sum() * q.sum()) / 720.0;
  return (lumped ? apart / 12.0 : 0.0) + across - bubble;
}

}  // namespace voile::energy

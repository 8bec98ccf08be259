#include "biot_force.hpp"

#include <Eigen/Dense>
#include <array>

namespace voile::energy {

BiotForce biot_force(const Hyperelastic& law, const Vec3& strain) {
  Hyperelastic own = law;
  own.natural = Mat3::Identity();
  own.area = 1.0;
  const Vec3 e = law.natural * strain;
  const HyperelasticResponse r = response(own, e);
  if (!r.possible) return {};
  Mat2 c;
  c << 1.0 + 2.0 * e[0], e[2], e[2], 1.0 + 2.0 * e[1];
  Eigen::SelfAdjointEigenSolver<Mat2> solver;
  solver.computeDirect(c);
  const Vec2 stretch = solver.eigenvalues().cwiseSqrt();
  // Strains along the axes, which are also what takes the tangent to them.
  std::array<Vec3, 2> along;
  Vec2 force;
  for (int i = 0; i < 2; ++i) {
    const Vec2 n = solver.eigenvectors().col(i);
    along[static_cast<std::size_t>(i)] = Vec3(n[0] * n[0], n[1] * n[1], 2.0 * n[0] * n[1]);
    force[i] = stretch[i] * along[static_cast<std::size_t>(i)].dot(r.force);
  }
  BiotForce b;
  Mat2 stiffness;
  for (int i = 0; i < 2; ++i) {
    const Vec3& a = along[static_cast<std::size_t>(i)];
    b.force += force[i] * Vec3(a[0], a[1], 0.5 * a[2]);
    for (int j = 0; j < 2; ++j)
      stiffness(i, j) = stretch[i] * stretch[j] * a.dot(r.tangent * along[static_cast<std::size_t>(j)]) +
                        (i == j ? force[i] / stretch[i] : 0.0);
  }
  if (stiffness.trace() > 0.0 && stiffness.determinant() > 0.0) b.softness = force.dot(stiffness.inverse() * force);
  return b;
}

}  // namespace voile::energy

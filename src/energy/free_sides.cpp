#include "free_sides.hpp"

#include <Eigen/Dense>

#include "curvature.hpp"

namespace voile::energy {

Mat3 condense_free_sides(const std::vector<Vec3>& free_sides, const Mat3& bending) {
  if (free_sides.empty()) return Mat3::Identity();
  if (free_sides.size() == 3) return Mat3::Zero();
  if (free_sides.size() == 1) {
    const Vec3 q = free_sides[0].normalized(), qd = bending * q;
    return Mat3::Identity() - q * qd.transpose() / q.dot(qd);
  }
  Eigen::Matrix<double, 3, 2> q;
  q << free_sides[0].normalized(), free_sides[1].normalized();
  const Eigen::Matrix<double, 2, 3> qd = q.transpose() * bending;
  return Mat3::Identity() - q * Mat2(qd * q).inverse() * qd;
}

Mat3 free_side_projector(const Sheet& sheet, Index t) {
  if (sheet.options().bending == BendingOperator::six_node) return Mat3::Identity();
  const mesh::Patch patch = sheet.patches().patch(t, sheet.frame(t));
  std::vector<Vec3> free_sides;
  for (int s = 0; s < 3; ++s) {
    if (patch.points[3 + s] != no_index) continue;
    const Vec2 along = patch.coordinates[(s + 2) % 3] - patch.coordinates[(s + 1) % 3], n(along.y(), -along.x());
    free_sides.emplace_back(n.x() * n.x(), n.y() * n.y(), 2.0 * n.x() * n.y());
  }
  return condense_free_sides(free_sides, sheet.material(t).bending);
}

}  // namespace voile::energy

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "voile/adapt/transfer.hpp"
#include "voile/base/error.hpp"

namespace voile::adapt {

namespace {

Vec3 centre_of(const std::vector<double>& mass, const std::vector<Vec3>& places) {
  Vec3 sum = Vec3::Zero();
  double total = 0.0;
  for (std::size_t v = 0; v < mass.size(); ++v) {
    sum += mass[v] * places[v];
    total += mass[v];
  }
  return sum / total;
}

Mat3 cross_matrix(const Vec3& r) {
  Mat3 m;
  m << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return m;
}

}  // namespace

Momentum momentum(const Motion& motion) {
  Momentum m;
  const Vec3 centre = centre_of(motion.mass, motion.places);
  for (std::size_t v = 0; v < motion.mass.size(); ++v) {
    const Vec3 p = motion.mass[v] * motion.velocity[v];
    m.linear += p;
    m.angular += (motion.places[v] - centre).cross(p);
  }
  return m;
}

void conserve_momentum(const Motion& old_motion, const std::vector<double>& mass, const std::vector<Vec3>& places,
                       const std::vector<char>& held, std::vector<Vec3>& velocity) {
  if (mass.size() != places.size() || mass.size() != velocity.size() || (!held.empty() && held.size() != mass.size()))
    throw InternalError("momentum: lengths of arrays do not fit");
  const Momentum before = momentum(old_motion);
  const Vec3 centre = centre_of(mass, places);
  double size = 0.0;
  for (const Vec3& x : places) size = std::max(size, (x - centre).norm());
  if (!(size > 0.0)) size = 1.0;
  // Velocity added to free vertices: a + w x r / size, so that both unknowns are velocities. A second pass takes off what
  // round-off left.
  for (int pass = 0; pass < 2; ++pass) {
    const Momentum now = momentum({mass, places, velocity});
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(6, 6);
    Eigen::VectorXd wanted(6);
    for (int d = 0; d < 3; ++d) {
      wanted[d] = before.linear[d] - now.linear[d];
      wanted[3 + d] = (before.angular[d] - now.angular[d]) / size;
    }
    for (std::size_t v = 0; v < mass.size(); ++v) {
      if (!held.empty() && held[v]) continue;
      const Mat3 r = cross_matrix(places[v] - centre) / size;
      m.topLeftCorner<3, 3>() += mass[v] * Mat3::Identity();
      m.topRightCorner<3, 3>() -= mass[v] * r;
      m.bottomLeftCorner<3, 3>() += mass[v] * r;
      m.bottomRightCorner<3, 3>() -= mass[v] * r * r;
    }
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(1e-10);
    const Eigen::VectorXd motion = solver.compute(m).solve(wanted);
    const Vec3 shift = motion.head<3>(), turn = motion.tail<3>() / size;
    for (std::size_t v = 0; v < mass.size(); ++v)
      if (held.empty() || !held[v]) velocity[v] += shift + turn.cross(places[v] - centre);
  }
}

}  // namespace voile::adapt

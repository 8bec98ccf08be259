#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/cross_matrix.hpp"
#include "base/decompositions.hpp"
#include "transfer.hpp"
#include "voile/errors.hpp"

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

namespace {

/// Of kinetic energy, as a fraction.
constexpr double round_off = 1e-20;

/// The rigid motion of free vertices that has a given momentum, as velocity at the centre and turning times `size`.
class RigidMotion {
 public:
  RigidMotion(const std::vector<double>& mass, const std::vector<Vec3>& places, const std::vector<char>& held)
      : places_(places), held_(held), centre_(centre_of(mass, places)) {
    for (const Vec3& x : places) size_ = std::max(size_, (x - centre_).norm());
    if (!(size_ > 0.0)) size_ = 1.0;
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(6, 6);
    for (std::size_t v = 0; v < mass.size(); ++v) {
      if (!is_free(v)) continue;
      const Mat3 r = cross_matrix(places[v] - centre_) / size_;
      m.topLeftCorner<3, 3>() += mass[v] * Mat3::Identity();
      m.topRightCorner<3, 3>() -= mass[v] * r;
      m.bottomLeftCorner<3, 3>() += mass[v] * r;
      m.bottomRightCorner<3, 3>() -= mass[v] * r * r;
    }
    solver_.emplace(m, 1e-10);
  }
  [[nodiscard]] bool is_free(std::size_t v) const { return held_.empty() || !held_[v]; }
  void fit(const Momentum& wanted) {
    Eigen::VectorXd both(6);
    both << wanted.linear, wanted.angular / size_;
    const Eigen::VectorXd motion = solver_->solve(both);
    shift_ = motion.head<3>();
    turn_ = motion.tail<3>() / size_;
  }
  [[nodiscard]] Vec3 at(std::size_t v) const { return shift_ + turn_.cross(places_[v] - centre_); }

 private:
  const std::vector<Vec3>& places_;
  const std::vector<char>& held_;
  Vec3 centre_, shift_ = Vec3::Zero(), turn_ = Vec3::Zero();
  double size_ = 0.0;
  std::optional<LeastSquares> solver_;
};

void check_lengths(const std::vector<double>& mass, const std::vector<Vec3>& places, const std::vector<char>& held,
                   const std::vector<Vec3>& velocity) {
  if (mass.size() != places.size() || mass.size() != velocity.size() || (!held.empty() && held.size() != mass.size()))
    throw InternalError("momentum: lengths of arrays do not fit");
}

}  // namespace

void conserve_momentum(const Motion& old_motion, const std::vector<double>& mass, const std::vector<Vec3>& places,
                       const std::vector<char>& held, std::vector<Vec3>& velocity) {
  const auto of = [&](const std::vector<Vec3>& v) { return momentum({mass, places, v}); };
  conserve_momentum(momentum(old_motion), of, mass, places, held, velocity);
}

void conserve_momentum(const Momentum& wanted, const std::function<Momentum(const std::vector<Vec3>&)>& of,
                       const std::vector<double>& mass, const std::vector<Vec3>& places, const std::vector<char>& held,
                       std::vector<Vec3>& velocity) {
  check_lengths(mass, places, held, velocity);
  RigidMotion added(mass, places, held);
  // A second pass takes off what round-off left.
  for (int pass = 0; pass < 2; ++pass) {
    const Momentum now = of(velocity);
    added.fit({wanted.linear - now.linear, wanted.angular - now.angular});
    for (std::size_t v = 0; v < mass.size(); ++v)
      if (added.is_free(v)) velocity[v] += added.at(v);
  }
}

double add_kinetic_energy(const std::vector<double>& mass, const std::vector<Vec3>& places,
                          const std::vector<char>& held, const Addition& addition, std::vector<Vec3>& velocity) {
  check_lengths(mass, places, held, velocity);
  RigidMotion rigid(mass, places, held);
  std::vector<Vec3> free = velocity;
  for (std::size_t v = 0; v < mass.size(); ++v)
    if (!rigid.is_free(v)) free[v].setZero();
  // About the centre of all, as the momentum is.
  rigid.fit(momentum({mass, places, free}));
  double rest = 0.0, all = 0.0;
  for (std::size_t v = 0; v < mass.size(); ++v) all += 0.5 * mass[v] * velocity[v].squaredNorm();
  for (std::size_t v = 0; v < mass.size(); ++v)
    if (rigid.is_free(v)) rest += 0.5 * mass[v] * (velocity[v] - rigid.at(v)).squaredNorm();
  // A rigid motion has nothing but round-off to change.
  const double square = rest > round_off * all ? 1.0 + addition.energy / rest : 1.0;
  const double factor = std::clamp(std::sqrt(std::max(square, 0.0)), 1.0 - addition.most, 1.0 + addition.most);
  for (std::size_t v = 0; v < mass.size(); ++v)
    if (rigid.is_free(v)) velocity[v] = rigid.at(v) + factor * (velocity[v] - rigid.at(v));
  return factor;
}

}  // namespace voile::adapt

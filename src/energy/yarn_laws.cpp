#include "yarn_laws.hpp"

#include <algorithm>
#include <cmath>

namespace voile::energy {

namespace {

/// Phi
double work_of(double slip, double limit, double rise) {
  return slip * (limit + 0.5 * rise * std::abs(slip));
}

}  // namespace

YarnLaws::YarnLaws(const std::vector<Material>& materials, double factor) : factor_(factor) {
  for (const Material& m : materials) {
    any_ = any_ || m.yarns.any();
    rub_ = rub_ || m.yarns.rubs();
    for (const auto& knots : m.yarns.knots) knots_ = std::max(knots_, static_cast<int>(knots.size()));
  }
}

void YarnLaws::add(const Batches::Place& place, double area, const YarnLaw& law) {
  std::vector<double> numbers(lines_per_batch(), 0.0);
  const Mat3 turn = turned_strain(law.warp_angle);
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t k = 0; k < 3; ++k)
      numbers[yarn_law_fields::turn + 3 * r + k] = turn(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(k));
  const double rubbing = area / factor_;
  numbers[yarn_law_fields::stiffness] = rubbing * law.stiffness;
  numbers[yarn_law_fields::limit] = rubbing * law.limit;
  numbers[yarn_law_fields::rise] = rubbing * law.rise;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t j = 0; j < law.knots[r].size(); ++j) {
      const std::size_t at = yarn_law_fields::knots + 2 * (static_cast<std::size_t>(knots_) * r + j);
      numbers[at] = law.knots[r][j].strain;
      numbers[at + 1] = area * law.knots[r][j].bend;
    }
  const std::size_t first = place.batch * lines_per_batch();
  lines_.resize(std::max(lines_.size(), first + lines_per_batch()));
  for (std::size_t i = 0; i < numbers.size(); ++i)
    for (auto lane = static_cast<std::size_t>(place.lane); lane < batch_lanes; ++lane)
      lines_[first + i].of[lane] = numbers[i];
}

void YarnLaws::set_slip(const Batches::Place& place, double slip) {
  Line& line = lines_[place.batch * lines_per_batch() + yarn_law_fields::slip];
  line.of[static_cast<std::size_t>(place.lane)] = slip;
}

double YarnLaws::slip_at(const Batches::Place& place, const Vec3& strain) const {
  const double held = number(place, yarn_law_fields::stiffness), limit = number(place, yarn_law_fields::limit),
               rise = number(place, yarn_law_fields::rise), slip = number(place, yarn_law_fields::slip);
  double shear = 0.0;
  for (int k = 0; k < 3; ++k) shear += number(place, yarn_law_fields::turn + 6 + k) * strain[k];
  const double trial = held * (shear - slip);
  if (std::abs(trial) <= limit + rise * std::abs(slip)) return slip;
  const double side = std::copysign(1.0, trial), top = held * shear - side * limit;
  return top / (held + side * std::copysign(1.0, top) * rise);
}

double YarnLaws::lost_at(const Batches::Place& place, const Vec3& strain) const {
  const double limit = number(place, yarn_law_fields::limit), rise = number(place, yarn_law_fields::rise);
  return factor_ * std::abs(work_of(slip_at(place, strain), limit, rise) - work_of(slip(place), limit, rise));
}

}  // namespace voile::energy

#include "yarn_friction.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "angle_bending.hpp"

namespace voile::energy {

namespace {

/// By how much a slider slips at this curvature.
double slipped(double curvature, double slip, double stiffness, double limit) {
  const double trial = stiffness * (curvature - slip), over = std::abs(trial) - limit;
  return stiffness > 0.0 && over > 0.0 ? std::copysign(over / stiffness, trial) : 0.0;
}

}  // namespace

YarnFrictionTerm::YarnFrictionTerm(const Sheet& sheet) {
  for (const Material& m : sheet.materials())
    sliders_per_direction_ = std::max(sliders_per_direction_, static_cast<int>(m.friction.sliders.size()));
}

bool YarnFrictionTerm::is_needed(const Sheet& sheet) {
  return std::any_of(sheet.materials().begin(), sheet.materials().end(),
                     [](const Material& m) { return !m.friction.sliders.empty(); });
}

bool YarnFrictionTerm::acts_on(const Sheet& sheet, Index t) {
  if (sheet.material(t).friction.sliders.empty()) return false;
  if (sheet.options().bending == BendingOperator::edge_angle) return true;
  return !bends_by_angles(sheet, t);
}

void YarnFrictionTerm::add(const Sheet& sheet, Index t, const BendingElement& bending, const std::vector<Index>& local,
                           bool owned) {
  const YarnFriction& friction = sheet.material(t).friction;
  const Mat3 turn = turned_strain(friction.warp_angle);
  const Vec3 rest = turn * bending.rest_curvature;
  const Mat3 start = turn * (bending.rest_curvature * bending.start_normal.transpose() + bending.start_bend);
  std::vector<double> numbers(rest.begin(), rest.end());
  for (int r = 0; r < directions; ++r)
    for (int k = 0; k < 3; ++k) numbers.push_back(start(r, k));
  for (Eigen::Index i = 0; i < bending.operator_.cols(); ++i) {
    const Vec3 weight = turn * bending.operator_.col(i);
    numbers.insert(numbers.end(), weight.begin(), weight.end());
  }
  const Batches::Place place = batches_.add({local, numbers, owned});
  triangles_.push_back(t);
  area_.push_back(sheet.mesh().area(t));
  const std::size_t lines =
      static_cast<std::size_t>(yarn_fields::per_slider) * static_cast<std::size_t>(this->numbers());
  sliders_.resize(lines * batches_.all().size());
  const double area = area_.back();
  for (std::size_t j = 0; j < friction.sliders.size(); ++j)
    for (int r = 0; r < directions; ++r) {
      const bool any = friction.sliders[j].limit[r] > 0.0;
      const double held = any ? area * friction.sliders[j].stiffness[r] : 0.0;
      const double most = any ? area * friction.sliders[j].limit[r] : 0.0;
      Line* at =
          &sliders_[lines * place.batch + yarn_fields::per_slider * (directions * j + static_cast<std::size_t>(r))];
      // The lanes that follow repeat it until others come.
      for (auto lane = static_cast<std::size_t>(place.lane); lane < batch_lanes; ++lane) {
        at[slip].of[lane] = 0.0;
        at[stiffness].of[lane] = held;
        at[limit].of[lane] = most;
        at[compliance].of[lane] = held > 0.0 ? 1.0 / held : 0.0;
      }
    }
  for (std::size_t j = friction.sliders.size(); j < static_cast<std::size_t>(sliders_per_direction_); ++j)
    for (std::size_t k = 0; k < static_cast<std::size_t>(yarn_fields::per_slider) * directions; ++k)
      for (auto lane = static_cast<std::size_t>(place.lane); lane < batch_lanes; ++lane)
        sliders_[lines * place.batch + yarn_fields::per_slider * directions * j + k].of[lane] = 0.0;
}

YarnBatch YarnFrictionTerm::view(std::size_t batch) const {
  const Batches::Batch& b = batches_.all()[batch];
  const int* points = batches_.points(b);
  const std::size_t lines = static_cast<std::size_t>(yarn_fields::per_slider) * static_cast<std::size_t>(numbers());
  return {
      batches_.fields(b),    sliders_[lines * batch].of.data(), points, points, batches_.slots(b), b.size, 0, b.lanes,
      sliders_per_direction_};
}

double YarnFrictionTerm::add_gradients(const Configuration& c, Vec3* force) const {
  const KernelState state{coordinates(c.x), coordinates(c.u)};
  double sum = 0.0;
  for (std::size_t b = 0; b < batches_.all().size(); ++b) {
    Line energy;
    kernels_->yarns.gradient(view(b), state, force->data(), energy.of.data());
    sum += batches_.all()[b].owned_sum(energy);
  }
  return sum;
}

void YarnFrictionTerm::add_tangents(const Configuration& c, double* blocks) const {
  const KernelState state{coordinates(c.x), coordinates(c.u), nullptr, c.tangent == Tangent::positive};
  for (std::size_t b = 0; b < batches_.all().size(); ++b) kernels_->yarns.tangent(view(b), state, blocks);
}

std::size_t YarnFrictionTerm::line_of(Index e, int slider, int direction, Number which) const {
  const std::size_t at = batches_.place(e).batch * static_cast<std::size_t>(numbers()) +
                         static_cast<std::size_t>(directions * slider + direction);
  return yarn_fields::per_slider * at + which;
}
double& YarnFrictionTerm::number(Index e, int slider, int direction, Number which) {
  return sliders_[line_of(e, slider, direction, which)].of[static_cast<std::size_t>(batches_.place(e).lane)];
}
double YarnFrictionTerm::number(Index e, int slider, int direction, Number which) const {
  return sliders_[line_of(e, slider, direction, which)].of[static_cast<std::size_t>(batches_.place(e).lane)];
}

Vec3 YarnFrictionTerm::curvature(Index e, const Configuration& c) const {
  const Index* p = stencil(e);
  const Vec3 edge = c.x[p[1]] - c.x[p[0]], normal = edge.cross(Vec3(c.x[p[2]] - c.x[p[0]])).normalized();
  Vec3 kappa;
  for (int r = 0; r < directions; ++r) {
    Vec3 bend;
    for (int k = 0; k < 3; ++k) bend[k] = batches_.number(e, yarn_fields::start + 3 * r + k);
    for (int i = 1; i < stencil_size(e); ++i)
      bend += batches_.number(e, yarn_fields::weights + directions * i + r) * (c.u[p[i]] - c.u[p[0]]);
    kappa[r] = normal.dot(bend) - batches_.number(e, yarn_fields::rest + r);
  }
  return kappa;
}

double YarnFrictionTerm::lost(const Configuration& c) const {
  double sum = 0.0;
  for (Index e = 0; e < size(); ++e) {
    if (!owned(e)) continue;
    const Vec3 kappa = curvature(e, c);
    for (int j = 0; j < sliders_per_direction_; ++j)
      for (int r = 0; r < directions; ++r)
        sum += number(e, j, r, limit) *
               std::abs(slipped(kappa[r], number(e, j, r, slip), number(e, j, r, stiffness), number(e, j, r, limit)));
  }
  return sum;
}

void YarnFrictionTerm::end_step(const Configuration& c) {
  for (Index e = 0; e < size(); ++e) {
    const Vec3 kappa = curvature(e, c);
    for (int j = 0; j < sliders_per_direction_; ++j)
      for (int r = 0; r < directions; ++r) {
        double& p = number(e, j, r, slip);
        p += slipped(kappa[r], p, number(e, j, r, stiffness), number(e, j, r, limit));
      }
  }
  ++version_;
}

std::vector<double> YarnFrictionTerm::slips(Index e) const {
  std::vector<double> all;
  for (int j = 0; j < sliders_per_direction_; ++j)
    for (int r = 0; r < directions; ++r) all.push_back(number(e, j, r, slip));
  return all;
}

void YarnFrictionTerm::set_slips(Index e, const double* slips) {
  for (int j = 0; j < sliders_per_direction_; ++j)
    for (int r = 0; r < directions; ++r) number(e, j, r, slip) = *slips++;
  ++version_;
}

Vec3 YarnFrictionTerm::moment(Index e, const Configuration& c) const {
  const Vec3 kappa = curvature(e, c);
  const double per_area = 1.0 / area_[static_cast<std::size_t>(e)];
  Vec3 sum = Vec3::Zero();
  for (int j = 0; j < sliders_per_direction_; ++j)
    for (int r = 0; r < directions; ++r) {
      const double most = number(e, j, r, limit);
      sum[r] += per_area * std::clamp(number(e, j, r, stiffness) * (kappa[r] - number(e, j, r, slip)), -most, most);
    }
  return sum;
}

}  // namespace voile::energy

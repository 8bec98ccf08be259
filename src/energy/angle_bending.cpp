#include "angle_bending.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace voile::energy {

void AngleBendingTerm::add(const BendingElement& bending, const EdgeAngles& angles, const std::vector<Index>& local,
                           const Mat3& stiffness, bool owned) {
  const Mat3 factor = Eigen::LLT<Mat3>(stiffness).matrixL();
  const auto first = static_cast<int>(hinges_.size());
  for (const EdgeAngles::Edge& edge : angles.edges) add_hinge(edge, bending, local, factor);
  std::vector<double> numbers;
  const auto write = [&](const Vec3& a) {
    for (const double number : a) numbers.push_back(number);
  };
  write(factor.transpose() * angles.rest);
  const Mat3 start = factor.transpose() * bending.start_bend;
  for (int r = 0; r < 3; ++r) write(start.row(r).transpose());
  for (Eigen::Index i = 0; i < bending.operator_.cols(); ++i) write(factor.transpose() * bending.operator_.col(i));
  const Batches::Place place = batches_.add({local, numbers, owned});
  first_hinge_.resize(batches_.all().size());
  last_hinge_.resize(batches_.all().size());
  for (auto lane = static_cast<std::size_t>(place.lane); lane < batch_lanes; ++lane) {
    first_hinge_[place.batch][lane] = first;
    last_hinge_[place.batch][lane] = static_cast<int>(hinges_.size());
  }
  factor_.push_back({factor(0, 0), factor(1, 0), factor(2, 0), factor(1, 1), factor(2, 1), factor(2, 2)});
}

void AngleBendingTerm::add_hinge(const EdgeAngles::Edge& edge, const BendingElement& bending,
                                 const std::vector<Index>& local, const Mat3& factor) {
  std::array<std::size_t, 4> at{};
  for (std::size_t k = 0; k < 4; ++k)
    at[k] = static_cast<std::size_t>(std::find(bending.points.begin(), bending.points.end(), edge.points[k]) -
                                     bending.points.begin());
  if (local[at[0]] > local[at[1]]) at = {at[1], at[0], at[3], at[2]};  // the same edge from its other side
  const Ends ends{local[at[0]], local[at[1]], local[at[2]], local[at[3]]};
  const auto [found, is_new] = number_of_.try_emplace(ends, edge_count());
  if (is_new) edges_.push_back(ends);
  HingeAt hinge{found->second, {}};
  for (std::size_t k = 0; k < 4; ++k) hinge.at[k] = static_cast<unsigned char>(at[k]);
  const std::size_t number = hinges_.size();
  hinges_.push_back(hinge);
  if (hinge_weights_.size() < number / 2 + 1) hinge_weights_.emplace_back();
  const Vec3 weight = factor.transpose() * edge.weight;
  for (int r = 0; r < 3; ++r) hinge_weights_.back().of[4 * (number % 2) + r] = weight[r];
}

void AngleBendingTerm::end_adding() {
  number_of_.clear();
  edge_points_.assign(4 * edge_batches(), {});
  for (std::size_t k = 0; k < edges_.size(); ++k)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t lane = k % batch_lanes; lane < batch_lanes; ++lane)
        edge_points_[4 * (k / batch_lanes) + i][lane] = edges_[k][i];
  angle_.resize(edge_batches());
  pull_.resize(edge_batches());
}

Vec3 AngleBendingTerm::unscaled(Index e, const Vec3& kappa) const {
  const auto& l = factor_[e];
  Vec3 k;  // of L^T k = kappa
  k[2] = kappa[2] / l[5];
  k[1] = (kappa[1] - l[4] * k[2]) / l[3];
  k[0] = (kappa[0] - l[1] * k[1] - l[2] * k[2]) / l[0];
  return k;
}

Vec3 AngleBendingTerm::rest_curvature(Index e) const {
  Vec3 rest;
  for (int r = 0; r < 3; ++r) rest[r] = batches_.number(e, angle_fields::rest + r);
  return unscaled(e, rest);
}

void AngleBendingTerm::set_rest_curvature(Index e, const Vec3& curvature) {
  ++version_;
  const auto& l = factor_[e];
  const Vec3 scaled(l[0] * curvature[0] + l[1] * curvature[1] + l[2] * curvature[2],
                    l[3] * curvature[1] + l[4] * curvature[2], l[5] * curvature[2]);
  for (int r = 0; r < 3; ++r) batches_.set_number(e, angle_fields::rest + r, scaled[r]);
}

Vec3 AngleBendingTerm::curvature(Index e, const Configuration& c) const {
  const Batches::Place place = batches_.place(e);
  Vec3 kappa;
  for (int r = 0; r < 3; ++r) kappa[r] = -batches_.number(e, angle_fields::rest + r);
  for (int h = first_hinge_[place.batch][place.lane]; h < last_hinge_[place.batch][place.lane]; ++h) {
    const Ends& p = edges_[hinges_[h].edge];
    const double angle = edge_angle({c.x[p[0]], c.x[p[1]], c.x[p[2]], c.x[p[3]]});
    for (int r = 0; r < 3; ++r) kappa[r] += angle * hinge_weights_[h / 2].of[4 * (h % 2) + r];
  }
  return unscaled(e, kappa);
}

EdgeBatch AngleBendingTerm::edge_view(std::size_t batch) const {
  const int* points = edge_points_[4 * batch].data();
  const std::size_t done = batch * batch_lanes;
  return {points,
          points,
          edge_slots_.empty() ? nullptr : edge_slots_[pairs_per_edge * batch].data(),
          static_cast<int>(std::min<std::size_t>(batch_lanes, edges_.size() - done)),
          angle_[batch].of.data(),
          slopes_.empty() ? nullptr : slopes_[16 * batch].of.data(),
          pull_[batch].of.data()};
}

AngleBatch AngleBendingTerm::view(std::size_t batch) const {
  const Batches::Batch& b = batches_.all()[batch];
  const int* points = batches_.points(b);
  return {batches_.fields(b),
          points,
          points,
          batches_.slots(b),
          hinges_.data(),
          hinge_weights_.front().of.data(),
          first_hinge_[batch].data(),
          last_hinge_[batch].data(),
          b.size,
          0,
          b.lanes};
}

double AngleBendingTerm::add_gradients(const Configuration& c, Vec3* force) const {
  const KernelState state{coordinates(c.x), coordinates(c.u)};
  std::fill(pull_.begin(), pull_.end(), Line{});
  for (std::size_t k = 0; k < edge_batches(); ++k) kernels_->edges.angles(edge_view(k), state);
  double sum = 0.0;
  for (std::size_t b = 0; b < batches_.all().size(); ++b) {
    Line energy;
    kernels_->angles.gradient(view(b), state, angle_.front().of.data(), pull_.front().of.data(), force->data(),
                              energy.of.data());
    sum += batches_.all()[b].owned_sum(energy);
  }
  for (std::size_t k = 0; k < edge_batches(); ++k) kernels_->edges.gradient(edge_view(k), state, force->data());
  return sum;
}

void AngleBendingTerm::add_tangents(const Configuration& c, double* blocks) const {
  const KernelState state{coordinates(c.x), coordinates(c.u)};
  slopes_.resize(16 * edge_batches());
  std::fill(pull_.begin(), pull_.end(), Line{});
  for (std::size_t k = 0; k < edge_batches(); ++k) kernels_->edges.slopes(edge_view(k), state);
  for (std::size_t b = 0; b < batches_.all().size(); ++b)
    kernels_->angles.tangent(view(b), angle_.front().of.data(), slopes_.front().of.data(), pull_.front().of.data(),
                             blocks);
  // Without second derivatives of angles the whole tangent, with K_b, is positive semidefinite.
  if (c.tangent == Tangent::positive) return;
  for (std::size_t k = 0; k < edge_batches(); ++k) kernels_->edges.tangent(edge_view(k), state, blocks);
}

}  // namespace voile::energy

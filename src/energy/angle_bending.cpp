#include "voile/energy/angle_bending.hpp"

#include <algorithm>

namespace voile::energy {

namespace {

/// Place of the pair i <= j among those of n points.
std::size_t upper_place(int i, int j, int n) {
  return static_cast<std::size_t>(i * n - i * (i - 1) / 2 + j - i);
}

}  // namespace

void AngleBendingTerm::add(const BendingElement& bending, const EdgeAngles& angles, const std::vector<Index>& local,
                           const Mat3& stiffness, bool owned) {
  elements_.push_back({points_.size(), edges_.size(), static_cast<int>(local.size()),
                       static_cast<int>(angles.edges.size()), owned, stiffness, angles.rest, bending.start_bend});
  for (const EdgeAngles::Edge& edge : angles.edges) {
    Edge stored{{}, edge.weight};
    for (std::size_t k = 0; k < 4; ++k)
      stored.at[k] = static_cast<int>(std::find(bending.points.begin(), bending.points.end(), edge.points[k]) -
                                      bending.points.begin());
    edges_.push_back(stored);
  }
  points_.insert(points_.end(), local.begin(), local.end());
  for (Eigen::Index i = 0; i < bending.operator_.cols(); ++i) weights_.push_back(bending.operator_.col(i));
}

EdgePoints AngleBendingTerm::points_of(const Element& el, const Edge& edge, const Configuration& c) const {
  const Index* p = points_.data() + el.start;
  return {c.x[p[edge.at[0]]], c.x[p[edge.at[1]]], c.x[p[edge.at[2]]], c.x[p[edge.at[3]]]};
}

Mat3 AngleBendingTerm::bend(const Element& el, const Configuration& c) const {
  Mat3 bend = el.start_bend;
  const Vec3& first =
      c.u[points_[el.start]];  // keeps round-off small where the sheet has moved far: the B' add up to zero
  for (std::size_t i = el.start + 1; i < el.start + static_cast<std::size_t>(el.count); ++i)
    bend += weights_[i] * (c.u[points_[i]] - first).transpose();
  return bend;
}

Vec3 AngleBendingTerm::curvature(Index e, const Configuration& c) const {
  const Element& el = elements_[e];
  Vec3 kappa = -el.rest;
  for (std::size_t k = el.first_edge; k < el.first_edge + static_cast<std::size_t>(el.edges); ++k)
    kappa += edge_angle(points_of(el, edges_[k], c)) * edges_[k].weight;
  return kappa;
}

double AngleBendingTerm::energy(Index e, const Configuration& c) const {
  const Element& el = elements_[e];
  const Vec3 kappa = curvature(e, c);
  const Mat3 constant = bend(el, c);
  return 0.5 * (kappa.dot(el.stiffness * kappa) - constant.cwiseProduct(el.stiffness * constant).sum());
}

void AngleBendingTerm::gradient_of(Index e, const Configuration& c, std::array<Vec3, most>& g) const {
  const Element& el = elements_[e];
  const Vec3 moment = el.stiffness * curvature(e, c);
  const Mat3 constant = el.stiffness * bend(el, c);
  for (int i = 0; i < el.count; ++i)
    g[static_cast<std::size_t>(i)] = -constant.transpose() * weights_[el.start + static_cast<std::size_t>(i)];
  for (std::size_t k = el.first_edge; k < el.first_edge + static_cast<std::size_t>(el.edges); ++k) {
    const EdgePoints slopes = edge_angle_slopes(points_of(el, edges_[k], c));
    const double pull = moment.dot(edges_[k].weight);
    for (std::size_t i = 0; i < 4; ++i) g[static_cast<std::size_t>(edges_[k].at[i])] += pull * slopes[i];
  }
}

void AngleBendingTerm::hessian_of(Index e, const Configuration& c, Upper& k) const {
  const Element& el = elements_[e];
  std::array<Mat3, most> slope, stiff;  // of kappa by each point, and A D times that
  const auto count = static_cast<std::size_t>(el.count);
  for (std::size_t i = 0; i < count; ++i) slope[i].setZero();
  Vec3 kappa = -el.rest;
  for (std::size_t n = el.first_edge; n < el.first_edge + static_cast<std::size_t>(el.edges); ++n) {
    const Edge& edge = edges_[n];
    const EdgePoints x = points_of(el, edge, c), slopes = edge_angle_slopes(x);
    kappa += edge_angle(x) * edge.weight;
    for (std::size_t i = 0; i < 4; ++i)
      slope[static_cast<std::size_t>(edge.at[i])] += edge.weight * slopes[i].transpose();
  }
  for (std::size_t i = 0; i < count; ++i) stiff[i].noalias() = el.stiffness.lazyProduct(slope[i]);
  std::size_t at = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 constant = el.stiffness * weights_[el.start + i];
    for (std::size_t j = i; j < count; ++j, ++at) {
      k[at].noalias() = slope[i].transpose().lazyProduct(stiff[j]);
      k[at].diagonal().array() -= constant.dot(weights_[el.start + j]);
    }
  }
  // Without it the whole tangent, with K_b, is positive semidefinite.
  if (c.tangent != Tangent::positive) add_geometric(el, c, el.stiffness * kappa, k);
}

void AngleBendingTerm::add_geometric(const Element& el, const Configuration& c, const Vec3& moment, Upper& k) const {
  for (std::size_t n = el.first_edge; n < el.first_edge + static_cast<std::size_t>(el.edges); ++n) {
    const Edge& edge = edges_[n];
    const EdgeAngleCurvature second = edge_angle_curvature(points_of(el, edge, c));
    const double pull = moment.dot(edge.weight);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        if (edge.at[i] <= edge.at[j]) k[upper_place(edge.at[i], edge.at[j], el.count)] += pull * second[i][j];
  }
}

}  // namespace voile::energy

#include "loads.hpp"

#include <Eigen/Geometry>
#include <utility>

#include "base/cross_matrix.hpp"

namespace voile::energy {

void FollowerTerm::add_pressure(const std::array<Index, 3>& points, double pressure, int factor, bool owned,
                                Bulge bulge) {
  if (bulge.points.empty()) bulge.points.assign(points.begin(), points.end());
  elements_.push_back({std::move(bulge), pressure, false, owned, factor});
}

void FollowerTerm::add_moment(EdgeMoment on, Index triangle, double moment, int factor, bool owned) {
  elements_.push_back({{std::move(on.points), std::move(on.weights)}, moment, true, owned, factor, triangle, on.bend});
}

std::vector<EdgeBend> FollowerTerm::edge_bends() const {
  std::vector<EdgeBend> bends;
  for (const Element& el : elements_)
    if (el.is_moment && el.owned) bends.push_back({el.triangle, scaled(el) * el.bend});
  return bends;
}

FollowerTerm::Couple::Couple(const Element& el, const Configuration& c) {
  const auto x = el.positions(c);
  const Vec3& origin = x(0);
  edge = x(1) - origin;
  slope.setZero();
  for (int i = 1; i < el.bulge.size(); ++i) slope += el.bulge.weights[i] * (x(i) - origin);
  about = slope.cross(edge);
  lift = edge.norm() / about.squaredNorm() * about;
  foot = -slope.dot(edge) / edge.squaredNorm();
}

Mat3 FollowerTerm::Couple::lift_derivative(const Element& el, int j) const {
  const double length = edge.norm(), square = about.squaredNorm();
  const Mat3 of_about = length / square * (Mat3::Identity() - 2.0 * about * about.transpose() / square);
  const Mat3 turn = -el.bulge.weights[j] * cross_matrix(edge) + end(j) * cross_matrix(slope);
  return of_about * turn + end(j) / (length * square) * about * edge.transpose();
}

Vec3 FollowerTerm::Couple::foot_derivative(const Element& el, int j) const {
  return -(el.bulge.weights[j] * edge + end(j) * (slope + 2.0 * foot * edge)) / edge.squaredNorm();
}

Vec3 FollowerTerm::pressure_force(const Element& el, const Configuration& c) const {
  const auto x = el.positions(c);
  return scaled(el) / 6.0 * (x(1) - x(0)).cross(x(2) - x(0));
}

std::array<Mat3, 3> FollowerTerm::pressure_stiffness(const Element& el, const Configuration& c) const {
  const auto x = el.positions(c);
  const Mat3 d1 = -scaled(el) / 6.0 * cross_matrix(x(2) - x(0)), d2 = scaled(el) / 6.0 * cross_matrix(x(1) - x(0));
  return {Mat3(-d1 - d2), d1, d2};
}

}  // namespace voile::energy

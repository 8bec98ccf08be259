#include "loads.hpp"

#include <Eigen/Geometry>
#include <utility>

#include "base/cross_matrix.hpp"

namespace voile::energy {

namespace {

/// d/dx_j of (x1-x0) x (x2-x0).
std::array<Mat3, 3> area_vector_derivative(const Vec3& x0, const Vec3& x1, const Vec3& x2) {
  const Mat3 d1 = -cross_matrix(x2 - x0), d2 = cross_matrix(x1 - x0);
  return {Mat3(-d1 - d2), d1, d2};
}

}  // namespace

void FollowerTerm::add_pressure(const std::array<Index, 3>& points, double pressure, int factor, bool owned,
                                Bulge bulge) {
  if (bulge.points.empty()) bulge.points.assign(points.begin(), points.end());
  elements_.push_back({std::move(bulge), pressure, false, owned, factor});
}

void FollowerTerm::add_moment(Moment moment, int factor, bool owned) {
  elements_.push_back({{std::move(moment.points), std::move(moment.weights)},
                       moment.moment,
                       true,
                       owned,
                       factor,
                       moment.triangle,
                       moment.bend});
}

std::vector<EdgeBend> FollowerTerm::edge_bends() const {
  std::vector<EdgeBend> bends;
  for (const Element& el : elements_)
    if (el.turns() && el.owned) bends.push_back({el.triangle, scaled(el) * el.bend});
  return bends;
}

Vec3 FollowerTerm::normal(const Element& el, const Configuration& c) {
  const auto x = el.positions(c);
  return (x(1) - x(0)).cross(x(2) - x(0)).normalized();
}

std::array<Mat3, 3> FollowerTerm::normal_derivative(const Element& el, const Configuration& c) {
  const auto x = el.positions(c);
  const Vec3 m = (x(1) - x(0)).cross(x(2) - x(0));
  const Mat3 of_area = (Mat3::Identity() - m * m.transpose() / m.squaredNorm()) / m.norm();
  std::array<Mat3, 3> d = area_vector_derivative(x(0), x(1), x(2));
  for (Mat3& part : d) part = of_area * part;
  return d;
}

std::array<Vec3, 3> FollowerTerm::force(const Element& el, const Configuration& c) const {
  const auto x = el.positions(c);
  const Vec3 &x0 = x(0), &x1 = x(1), &x2 = x(2);
  const Vec3 e = x1 - x0, m = e.cross(x2 - x0);
  if (!el.is_moment) {
    const Vec3 f = scaled(el) / 6.0 * m;
    return {f, f, f};
  }
  const double alpha = (x2 - x0).dot(e) / e.squaredNorm();
  const Vec3 w = scaled(el) * e.norm() / m.squaredNorm() * m;
  return {Vec3((1.0 - alpha) * w), Vec3(alpha * w), Vec3(-w)};
}

void FollowerTerm::stiffness(const Element& el, const Configuration& c, std::array<std::array<Mat3, 3>, 3>& k) const {
  const auto x = el.positions(c);
  const Vec3 &x0 = x(0), &x1 = x(1), &x2 = x(2);
  const std::array<Mat3, 3> dm = area_vector_derivative(x0, x1, x2);
  if (!el.is_moment) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) k[i][j] = scaled(el) / 6.0 * dm[j];
    return;
  }
  const Vec3 e = x1 - x0, g = x2 - x0, m = e.cross(g);
  const double length = e.norm(), square = m.squaredNorm(), alpha = g.dot(e) / e.squaredNorm();
  const Vec3 w = scaled(el) * length / square * m;
  const Mat3 dw_dm = scaled(el) * length / square * (Mat3::Identity() - 2.0 * m * m.transpose() / square);
  const Mat3 dw_de = scaled(el) / (length * square) * m * e.transpose();
  const Vec3 dalpha_dg = e / e.squaredNorm(), dalpha_de = (g - 2.0 * alpha * e) / e.squaredNorm();
  const std::array<double, 3> de{-1.0, 1.0, 0.0}, dg{-1.0, 0.0, 1.0};
  for (int j = 0; j < 3; ++j) {
    const Mat3 dw = dw_dm * dm[j] + de[j] * dw_de;
    const Mat3 foot = w * (dg[j] * dalpha_dg + de[j] * dalpha_de).transpose();
    k[0][j] = (1.0 - alpha) * dw - foot;
    k[1][j] = alpha * dw + foot;
    k[2][j] = -dw;
  }
}

}  // namespace voile::energy

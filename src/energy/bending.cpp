#include "voile/energy/bending.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "voile/base/cross_matrix.hpp"

namespace voile::energy {

namespace {

/// Rest curvature below this fraction of 1/size counts as flat: it is round-off of the coordinates.
constexpr double flat_tolerance = 1e-10;

/// Operator with the triangle's vertices in front (added with zero weight where absent).
void order_points(const mesh::Triangle& corners, const CurvatureOperator& op, BendingElement& el) {
  el.points.assign(corners.begin(), corners.end());
  for (Index p : op.points)
    if (std::find(corners.begin(), corners.end(), p) == corners.end()) el.points.push_back(p);
  el.operator_.setZero(3, static_cast<Eigen::Index>(el.points.size()));
  for (std::size_t i = 0; i < op.points.size(); ++i) {
    const auto at = std::find(el.points.begin(), el.points.end(), op.points[i]) - el.points.begin();
    el.operator_.col(at) = op.weights.col(static_cast<Eigen::Index>(i));
  }
}

/// By how much the start is bent beyond the rest shape.
void take_start(const Sheet& sheet, Index t, BendingElement& el) {
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  el.start_normal = mesh.start_normal(t);
  const Vec3 corner = mesh.start_corner(t, 0);  // keeps round-off small
  Mat3 bend = -el.rest_curvature * el.start_normal.transpose();
  for (std::size_t i = 0; i < el.points.size(); ++i)
    bend += el.operator_.col(static_cast<Eigen::Index>(i)) * (sheet.patches().start(el.points[i]) - corner).transpose();
  const double area = mesh.area(t);
  if (!(bend.norm() * std::sqrt(area) > flat_tolerance)) return;
  const Mat3 moment = area * sheet.material(t).bending * bend;
  el.start_bend = bend;
  el.start_force = el.operator_.transpose() * moment;
  el.start_coupling = moment.transpose() * el.rest_curvature;
  el.start_energy = 0.5 * bend.cwiseProduct(moment).sum();
}

}  // namespace

BendingElement make_bending_element(const Sheet& sheet, Index t, const CurvatureOperator& op) {
  BendingElement el;
  order_points(sheet.mesh().triangles()[t], op, el);
  const mesh::Frame frame = sheet.frame(t);
  const double area = sheet.mesh().area(t);
  const Mat3& bending = sheet.material(t).bending;

  el.start_normal = frame.normal;
  el.rest_curvature = op.rest * frame.normal;
  const bool curved = op.rest.norm() * std::sqrt(area) > flat_tolerance;
  if (curved) {
    std::array<Vec2, 3> p;
    for (int i = 0; i < 3; ++i) p[i] = frame.to_plane(sheet.mesh().rest_corner(t, i));
    for (int i = 0; i < 3; ++i) {
      const Vec2 edge = p[(i + 2) % 3] - p[(i + 1) % 3];
      const Vec2 gradient = Vec2(-edge.y(), edge.x()) / (2.0 * area);
      el.operator_.col(i) -= op.rest * (frame.e1 * gradient.x() + frame.e2 * gradient.y());
    }
    el.coupling = area * (el.rest_curvature.transpose() * bending * el.operator_).transpose();
    el.rest_energy = area * el.rest_curvature.dot(bending * el.rest_curvature);
  } else {
    el.rest_curvature.setZero();
  }
  el.stiffness = area * el.operator_.transpose() * bending * el.operator_;
  if (sheet.mesh().has_charts()) take_start(sheet, t, el);
  return el;
}

void CurvedBendingTerm::add(const BendingElement& element, const std::vector<Index>& local, bool owned) {
  elements_.push_back({points_.size(), static_cast<int>(local.size()), owned, element.rest_energy, element.start_normal,
                       element.start_coupling});
  points_.insert(points_.end(), local.begin(), local.end());
  coupling_.insert(coupling_.end(), element.coupling.begin(), element.coupling.end());
}

CurvedBendingTerm::Normal CurvedBendingTerm::normal(const Element& el, const Configuration& c) const {
  const Index* p = points_.data() + el.start;
  Normal n;
  n.a = c.x[p[1]] - c.x[p[0]];
  n.b = c.x[p[2]] - c.x[p[0]];
  n.unit = n.a.cross(n.b);
  n.length = n.unit.norm();
  n.unit /= n.length;
  return n;
}

Vec3 CurvedBendingTerm::coupled(const Element& el, const Configuration& c) const {
  Vec3 v = el.rest_energy * el.normal + el.start_coupling;
  for (int i = 0; i < el.count; ++i) v += coupling_[el.start + i] * c.u[points_[el.start + i]];
  return v;
}

double CurvedBendingTerm::energy(Index e, const Configuration& c) const {
  const Element& el = elements_[e];
  const Vec3 n = normal(el, c).unit;
  const Vec3 change = coupled(el, c) - el.rest_energy * el.normal;
  return el.rest_energy * (1.0 - n.dot(el.normal)) + (el.normal - n).dot(change);
}

void CurvedBendingTerm::blocks_of(const Element& el, const Configuration& c, std::array<std::array<Mat3, 3>, 3>& centre,
                                  std::array<Mat3, 3>& mixed) const {
  const Normal n = normal(el, c);
  const Vec3 v = coupled(el, c);
  const Mat3 projector = Mat3::Identity() - n.unit * n.unit.transpose();
  const Vec3 pv = projector * v;
  const Mat3 second =
      (n.unit * pv.transpose() + pv * n.unit.transpose() + n.unit.dot(v) * projector) / (n.length * n.length);
  const Mat3 bilinear = cross_matrix(-pv / n.length);
  std::array<Mat3, 3> j;
  j[1] = -cross_matrix(n.b);
  j[2] = cross_matrix(n.a);
  j[0] = -j[1] - j[2];
  for (int i = 0; i < 3; ++i) mixed[i] = -j[i].transpose() * projector / n.length;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      centre[i][k] = j[i].transpose() * second * j[k] + coupling_[el.start + k] * mixed[i] +
                     coupling_[el.start + i] * mixed[k].transpose();
  // The normal direction m = a x b is bilinear: second derivative -[q]x for the pair (a, b), with a = x1-x0, b = x2-x0.
  centre[1][2] -= bilinear;
  centre[2][1] += bilinear;
  centre[1][0] += bilinear;
  centre[0][1] -= bilinear;
  centre[2][0] -= bilinear;
  centre[0][2] += bilinear;
}

}  // namespace voile::energy

#include "bending.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

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
  std::vector<double> numbers{element.rest_energy};
  for (const Vec3& a : {element.start_normal, element.start_coupling})
    for (const double number : a) numbers.push_back(number);
  for (const double number : element.coupling) numbers.push_back(number);
  batches_.add({local, numbers, owned});
}

void CurvedBendingTerm::add_natural(const BendingElement& element, const Mat3& stiffness,
                                    const std::vector<Index>& local, bool owned) {
  const Mat3 start = element.start_bend + element.rest_curvature * element.start_normal.transpose();
  natural_.push_back({element.rest_curvature, stiffness, stiffness * start, stiffness * element.operator_});
  batches_.add({local, std::vector<double>(curved_fields::coupling + local.size(), 0.0), owned});
}

void CurvedBendingTerm::set_natural(Index e, const Vec3& curvature) {
  ++version_;
  const Natural& n = natural_[e];
  const Vec3 change = curvature - n.rest, start = n.start.transpose() * change;
  batches_.set_number(e, curved_fields::rest_energy, change.dot(n.stiffness * (curvature + n.rest)));
  for (int k = 0; k < 3; ++k) batches_.set_number(e, curved_fields::start_coupling + k, start[k]);
  for (Eigen::Index i = 0; i < n.of.cols(); ++i)
    batches_.set_number(e, curved_fields::coupling + static_cast<int>(i), n.of.col(i).dot(change));
}

CurvedBatch CurvedBendingTerm::view(const Batches::Batch& b) const {
  const int* points = batches_.points(b);
  return {batches_.fields(b), points, points, batches_.slots(b), b.size, 0, b.lanes};
}

double CurvedBendingTerm::add_gradients(const Configuration& c, Vec3* force) const {
  const KernelState state{coordinates(c.x), coordinates(c.u)};
  double sum = 0.0;
  for (const Batches::Batch& b : batches_.all()) {
    Line energy;
    kernels_->curved.gradient(view(b), state, force->data(), energy.of.data());
    sum += b.owned_sum(energy);
  }
  return sum;
}

void CurvedBendingTerm::add_tangents(const Configuration& c, double* blocks) const {
  const KernelState state{coordinates(c.x), coordinates(c.u)};
  for (const Batches::Batch& b : batches_.all()) kernels_->curved.tangent(view(b), state, blocks);
}

}  // namespace voile::energy

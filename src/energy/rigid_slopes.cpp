#include <fmt/format.h>

#include <Eigen/Dense>

#include "free_slopes.hpp"
#include "voile/base/error.hpp"
#include "voile/energy/joint.hpp"

namespace voile::energy {

namespace {

/// Rows of JointElement::weights of a side: edge, direction of the body, g.
constexpr int rows_of_side = 3;

void refuse_coupling(const Sheet& sheet, Index t) {
  if (!couples(sheet.material(t))) return;
  const Vec3 x = sheet.mesh().start_corner(t, 0);
  throw UserError(fmt::format(
      "[[material]]: an unsymmetric laminate, or one with an `offset`, ends at a [[rigid]] edge near ({:.4g}, "
      "{:.4g}, {:.4g}) m; give it a symmetric one without offset there, or slope = \"free\"",
      x[0], x[1], x[2]));
}

/// Points of the operator, ends of the sides, frame, each once; their places at the start.
struct Points {
  std::vector<Index> points;
  std::vector<Vec3> start;
  Eigen::Index of(Index point, const Vec3& at) {
    const auto found = std::find(points.begin(), points.end(), point);
    if (found != points.end()) return found - points.begin();
    points.push_back(point);
    start.push_back(at);
    return static_cast<Eigen::Index>(points.size()) - 1;
  }
};

}  // namespace

JointElement make_rigid_slopes(const Sheet& sheet, CurvatureBuilder& curvatures, Index triangle,
                               const std::vector<int>& sides, const RigidFrame& frame) {
  refuse_coupling(sheet, triangle);
  const FreeSlopes slopes(sheet, curvatures, triangle);
  const CurvatureOperator& op = slopes.of.operator_;
  const mesh::Triangle& corners = sheet.mesh().triangles()[triangle];
  const auto start = [&](Index p) { return sheet.patches().start(p); };
  const auto count = static_cast<Eigen::Index>(sides.size());
  JointElement el;
  Points of;
  for (const Index p : op.points) of.of(p, start(p));
  for (const Index p : corners) of.of(p, start(p));
  for (std::size_t k = 0; k < frame.points.size(); ++k) of.of(frame.points[k], frame.start[k]);
  el.points = of.points;
  el.weights.setZero(rows_of_side * count, static_cast<Eigen::Index>(of.points.size()));
  el.start.setZero(el.weights.rows(), 3);
  const double length = (frame.start[1] - frame.start[0]).norm();
  Eigen::MatrixXd compliance(count, count);
  Eigen::VectorXd sense(count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const int s = sides[static_cast<std::size_t>(n)], row = rows_of_side * static_cast<int>(n);
    const Eigen::Index k = slopes.row(s);
    el.weights(row, of.of(corners[static_cast<std::size_t>((s + 1) % 3)], {})) = -1.0;
    el.weights(row, of.of(corners[static_cast<std::size_t>((s + 2) % 3)], {})) = 1.0;
    const Eigen::RowVectorXd w = -slopes.natural.row(k) * op.weights;
    for (std::size_t i = 0; i < op.points.size(); ++i)
      el.weights(row + 2, of.of(op.points[i], {})) = w[static_cast<Eigen::Index>(i)];
    const Vec3 origin = of.start.front();  // keeps round-off small
    for (std::size_t i = 0; i < of.points.size(); ++i)
      for (const int r : {row, row + 2})
        el.start.row(r) += el.weights(r, static_cast<Eigen::Index>(i)) * (of.start[i] - origin).transpose();
    // The body's direction is that of the slope at the start, back into the sheet.
    const Vec3 back = -el.start.row(row + 2);
    el.start.row(row + 1) = back;
    for (int i = 0; i < 3; ++i) {
      el.weights(row + 1, of.of(frame.points[static_cast<std::size_t>(i + 1)], {})) += back[i] / length;
      el.weights(row + 1, of.of(frame.points[0], {})) -= back[i] / length;
    }
    const Vec3 edge = el.start.row(row), slope = el.start.row(row + 2);
    const EdgePoints x{Vec3::Zero(), edge, back, slope};
    sense[n] = edge_angle_slopes(x)[3].dot(sheet.mesh().start_normal(triangle)) > 0.0 ? 1.0 : -1.0;
    el.angles.push_back(
        {triangle, row, row + 1, row + 2, edge_angle(x), Vec3(sense[n] * slopes.natural.row(k).transpose())});
    for (Eigen::Index m = 0; m < count; ++m)
      compliance(n, m) = slopes.compliance(k, slopes.row(sides[static_cast<std::size_t>(m)]));
  }
  const Eigen::MatrixXd stiffness = compliance.inverse();
  el.stiffness = sense.asDiagonal() * stiffness * sense.asDiagonal();
  Eigen::MatrixXd of_joints(slopes.compliance.rows(), count);
  for (Eigen::Index n = 0; n < count; ++n)
    of_joints.col(n) = slopes.compliance.col(slopes.row(sides[static_cast<std::size_t>(n)]));
  el.bends.push_back({triangle, slopes.across * of_joints * stiffness * -sense.asDiagonal().toDenseMatrix()});
  return el;
}

}  // namespace voile::energy

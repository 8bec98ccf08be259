#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <utility>

#include "base/decompositions.hpp"
#include "free_slopes.hpp"
#include "joint.hpp"
#include "voile/errors.hpp"

namespace voile::energy {

namespace {

/// Rows of JointElement::weights of a side: edge, direction of the body, g.
constexpr int rows_of_side = 3;

void refuse_coupling(const Sheet& sheet, Index t) {
  if (!couples(sheet.material(t))) return;
  const Vec3 x = sheet.mesh().start_corner(t, 0);
  throw UserError(
      fmt::format("[[material]]: an unsymmetric laminate ends at a [[rigid]] or [[hinge]] "
                  "edge near ({:.4g}, "
                  "{:.4g}, {:.4g}) m; give it a symmetric one there, or leave the slope free",
                  x[0], x[1], x[2]));
}

class SideBuilder {
 public:
  /// `frame`: null is the ground.
  SideBuilder(const Sheet& sheet, CurvatureBuilder& curvatures, Index triangle, const RigidFrame* frame)
      : sheet_(sheet), triangle_(triangle), frame_(frame), slopes_(sheet, curvatures, triangle) {}

  /// `give`: 1 / (k l) of each side [1/(N m)].
  JointElement run(const std::vector<int>& sides, const Eigen::VectorXd& give) {
    collect_points();
    const auto count = static_cast<Eigen::Index>(sides.size());
    el_.weights.setZero(rows_of_side * count, static_cast<Eigen::Index>(el_.points.size()));
    el_.start.setZero(el_.weights.rows(), 3);
    Eigen::VectorXd sense(count);
    Eigen::MatrixXd compliance(count, count), of_joints(slopes_.compliance.rows(), count);
    for (Eigen::Index n = 0; n < count; ++n) {
      const int side = sides[static_cast<std::size_t>(n)];
      sense[n] = add_side(side, rows_of_side * static_cast<int>(n));
      of_joints.col(n) = slopes_.compliance.col(slopes_.row(side));
    }
    for (Eigen::Index n = 0; n < count; ++n)
      compliance.row(n) = of_joints.row(slopes_.row(sides[static_cast<std::size_t>(n)]));
    compliance.diagonal() += give;
    const Eigen::MatrixXd stiffness = inverse(compliance), senses = sense.asDiagonal();
    el_.stiffness = senses * stiffness * senses;
    el_.bends.push_back({triangle_, -slopes_.across * of_joints * stiffness * senses});
    return std::move(el_);
  }

 private:
  /// Those of the operator, of the triangle and of the frame, each once.
  void collect_points() {
    const auto add = [&](Index point, const Vec3& start) {
      if (std::find(el_.points.begin(), el_.points.end(), point) != el_.points.end()) return;
      el_.points.push_back(point);
      start_.push_back(start);
    };
    for (const Index p : slopes_.of.operator_.points) add(p, sheet_.patches().start(p));
    for (const Index p : corners()) add(p, sheet_.patches().start(p));
    for (std::size_t k = 0; frame_ && k < frame_->points.size(); ++k) add(frame_->points[k], frame_->start[k]);
  }
  [[nodiscard]] const mesh::Triangle& corners() const { return sheet_.mesh().triangles()[triangle_]; }
  [[nodiscard]] double& weight(int row, Index point) {
    return el_.weights(row, std::find(el_.points.begin(), el_.points.end(), point) - el_.points.begin());
  }

  /// Three rows from `row` on and the angle of a side; sigma.
  double add_side(int side, int row) {
    const CurvatureOperator& op = slopes_.of.operator_;
    const Eigen::Index k = slopes_.row(side);
    weight(row, corners()[static_cast<std::size_t>((side + 1) % 3)]) = -1.0;
    weight(row, corners()[static_cast<std::size_t>((side + 2) % 3)]) = 1.0;
    const Eigen::RowVectorXd slope = -slopes_.natural.row(k) * op.weights;
    for (std::size_t i = 0; i < op.points.size(); ++i)
      weight(row + 2, op.points[i]) = slope[static_cast<Eigen::Index>(i)];
    for (const int r : {row, row + 2}) el_.start.row(r) = start_of(r);
    // The body's direction is that of the slope at the start, back into the sheet.
    const Vec3 back = -el_.start.row(row + 2);
    el_.start.row(row + 1) = back;
    for (int i = 0; frame_ && i < 3; ++i) {
      const double part = back[i] / (frame_->start[1] - frame_->start[0]).norm();
      weight(row + 1, frame_->points[static_cast<std::size_t>(i) + 1]) += part;
      weight(row + 1, frame_->points[0]) -= part;
    }
    const EdgePoints x{Vec3::Zero(), el_.start.row(row), back, Vec3(-back)};
    const double sense = edge_angle_slopes(x)[3].dot(sheet_.mesh().start_normal(triangle_)) > 0.0 ? 1.0 : -1.0;
    el_.angles.push_back({triangle_, row, row + 1, row + 2, edge_angle(x), no_index, sense,
                          Vec3(sense * slopes_.natural.row(k).transpose())});
    return sense;
  }

  [[nodiscard]] Eigen::RowVector3d start_of(int row) const {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (std::size_t i = 0; i < start_.size(); ++i)  // from the first point on, which keeps round-off small
      sum += el_.weights(row, static_cast<Eigen::Index>(i)) * (start_[i] - start_.front()).transpose();
    return sum;
  }

  const Sheet& sheet_;
  Index triangle_;
  const RigidFrame* frame_;
  FreeSlopes slopes_;
  std::vector<Vec3> start_;  ///< places of the points [m]
  JointElement el_;
};

}  // namespace

JointElement make_rigid_slopes(const Sheet& sheet, CurvatureBuilder& curvatures, Index triangle,
                               const std::vector<int>& sides, const RigidFrame& frame) {
  refuse_coupling(sheet, triangle);
  return SideBuilder(sheet, curvatures, triangle, &frame)
      .run(sides, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(sides.size())));
}

JointElement make_grounded_slopes(const Sheet& sheet, CurvatureBuilder& curvatures, Index triangle,
                                  const GroundedSides& grounded) {
  refuse_coupling(sheet, triangle);
  Eigen::VectorXd give(static_cast<Eigen::Index>(grounded.sides.size()));
  const mesh::Triangle& v = sheet.mesh().triangles()[triangle];
  for (std::size_t k = 0; k < grounded.sides.size(); ++k) {
    const auto s = static_cast<std::size_t>(grounded.sides[k]);
    give[static_cast<Eigen::Index>(k)] =
        1.0 / (grounded.stiffness[k] * sheet.mesh().rest_length({v[(s + 1) % 3], v[(s + 2) % 3]}));
  }
  JointElement el = SideBuilder(sheet, curvatures, triangle, nullptr).run(grounded.sides, give);
  for (std::size_t k = 0; k < grounded.sides.size(); ++k) el.angles[k].joint = grounded.joints[k];
  return el;
}

}  // namespace voile::energy

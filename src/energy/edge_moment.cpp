#include "edge_moment.hpp"

#include <algorithm>

#include "free_slopes.hpp"

namespace voile::energy {

std::optional<EdgeMoment> make_edge_moment(const Sheet& sheet, CurvatureBuilder& curvatures, Index t, int s) {
  if (sheet.options().bending == BendingOperator::six_node) return {};
  const FreeSlopes slopes(sheet, curvatures, t);
  const Eigen::Index row = slopes.row(s);
  if (row == slopes.natural.rows()) return {};
  const mesh::Triangle& corners = sheet.mesh().triangles()[t];
  EdgeMoment made;
  for (const int k : {s + 1, s + 2, s}) made.points.push_back(corners[static_cast<std::size_t>(k % 3)]);
  made.weights.assign(made.points.size(), 0.0);
  const CurvatureOperator& op = slopes.of.operator_;
  const Eigen::RowVectorXd weights = -slopes.natural.row(row) * op.weights;
  for (std::size_t i = 0; i < op.points.size(); ++i) {
    const auto found = std::find(made.points.begin(), made.points.end(), op.points[i]);
    const auto place = static_cast<std::size_t>(found - made.points.begin());
    if (found == made.points.end()) {
      made.points.push_back(op.points[i]);
      made.weights.push_back(0.0);
    }
    made.weights[place] += weights[static_cast<Eigen::Index>(i)];
  }
  made.bend = slopes.across * slopes.compliance.col(row);
  return made;
}

}  // namespace voile::energy

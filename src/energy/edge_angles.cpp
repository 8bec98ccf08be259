#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "angle_bending.hpp"
#include "base/decompositions.hpp"

namespace voile::energy {

namespace {

/// Charts whose lengths differ by less count as of one scale.
constexpr double same_scale = 1e-6;

/// Angle at rest [rad] from which on a fold bends by slopes: closed by little more its angle would go from pi to -pi.
constexpr double folded_back = 150.0 * std::numbers::pi / 180.0;

/// An inner edge of the patch of a triangle.
struct Hinge {
  EdgeAngles::Edge edge;
  Eigen::Vector4d functional;  ///< h_e: factors of a, b, p, q
  double height;               ///< H_e
  double rest;                 ///< theta_e at rest
};

/// Of side s of the triangle whose patch it is.
Hinge make_hinge(const mesh::Patch& patch, int s) {
  const auto a = static_cast<std::size_t>((s + 1) % 3), b = static_cast<std::size_t>((s + 2) % 3),
             p = static_cast<std::size_t>(s), q = 3 + static_cast<std::size_t>(s);
  const Vec2 e = patch.coordinates[b] - patch.coordinates[a], to_p = patch.coordinates[p] - patch.coordinates[a],
             to_q = patch.coordinates[q] - patch.coordinates[a];
  const auto cross = [](const Vec2& u, const Vec2& v) { return u.x() * v.y() - u.y() * v.x(); };
  const double of_p = cross(e, to_q) / cross(e, to_p), of_b = cross(to_q, to_p) / cross(e, to_p);
  return {{{patch.points[a], patch.points[b], patch.points[p], patch.points[q]}, Vec3::Zero()},
          {of_b + of_p - 1.0, -of_b, -of_p, 1.0},
          std::abs(cross(e, to_q)) / e.norm(),
          edge_angle({patch.rest[a], patch.rest[b], patch.rest[p], patch.rest[q]})};
}

/// Edges between points of the element.
class Hinges {
 public:
  Hinges(const Sheet& sheet, const std::vector<Index>& points) : sheet_(&sheet), points_(&points) {}

  /// The sides of triangle t that have not been added from their other triangle.
  void add(Index t) {
    const mesh::SurfaceMesh& mesh = sheet_->mesh();
    const mesh::Patch patch = sheet_->patches().patch(t, sheet_->frame(t));
    for (int s = 0; s < 3; ++s) {
      const Index other = mesh.neighbour(t, s);
      if (!has(patch.points[3 + static_cast<std::size_t>(s)])) continue;
      if (other != no_index && !seen_.insert(std::minmax(3 * t + s, 3 * other + mesh.side_in_neighbour(t, s))).second)
        continue;
      even_ = even_ && std::abs(patch.stretch[static_cast<std::size_t>(s)] - 1.0) < same_scale;
      hinges_.push_back(make_hinge(patch, s));
    }
  }
  [[nodiscard]] bool has(Index p) const { return std::find(points_->begin(), points_->end(), p) != points_->end(); }
  /// Whether no chart is scaled against its neighbour.
  [[nodiscard]] bool even() const { return even_; }

  /// The angles that make up `weights`, B of each point, to the relative precision `within`. Pivots below `threshold` do not count.
  [[nodiscard]] std::optional<EdgeAngles> making_up(const Eigen::MatrixX3d& weights, double threshold,
                                                    double within) const {
    const auto count = static_cast<Eigen::Index>(hinges_.size());
    if (count == 0) return {};
    Eigen::MatrixXd of_angles = Eigen::MatrixXd::Zero(weights.rows(), count);
    for (Eigen::Index h = 0; h < count; ++h) {
      const Hinge& hinge = hinges_[static_cast<std::size_t>(h)];
      for (std::size_t k = 0; k < 4; ++k)
        of_angles(std::find(points_->begin(), points_->end(), hinge.edge.points[k]) - points_->begin(), h) +=
            hinge.functional[static_cast<Eigen::Index>(k)] / hinge.height;
    }
    const Eigen::MatrixXd fraction = LeastSquares(of_angles, threshold).solve(weights);
    if (!((of_angles * fraction - weights).norm() <= within * weights.norm())) return {};
    EdgeAngles angles;
    for (Eigen::Index h = 0; h < count; ++h) {
      EdgeAngles::Edge edge = hinges_[static_cast<std::size_t>(h)].edge;
      edge.weight = fraction.row(h).transpose();
      angles.rest += hinges_[static_cast<std::size_t>(h)].rest * edge.weight;
      angles.edges.push_back(edge);
    }
    return angles;
  }

 private:
  const Sheet* sheet_;
  const std::vector<Index>* points_;
  std::vector<Hinge> hinges_;
  std::set<std::pair<Index, Index>> seen_;
  bool even_ = true;
};

/// B of the points of the element, row by row.
Eigen::MatrixX3d weights_of(const CurvatureOperator& op, const std::vector<Index>& points) {
  Eigen::MatrixX3d weights = Eigen::MatrixX3d::Zero(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < op.points.size(); ++i)
    weights.row(std::find(points.begin(), points.end(), op.points[i]) - points.begin()) =
        op.weights.col(static_cast<Eigen::Index>(i)).transpose();
  return weights;
}

}  // namespace

bool bends_by_angles(const Sheet& sheet, Index t) {
  const ElementOptions& element = sheet.options();
  const bool all = element.bending == BendingOperator::edge_angle;
  const bool beside_folds =
      element.bending == BendingOperator::edge_slope && element.membrane == MembraneOperator::six_node_corrected;
  if (!all && !beside_folds) return false;
  double fold = 0.0;
  const auto see = [&](Index triangle) {
    for (int s = 0; s < 3; ++s) fold = std::max(fold, sheet.patches().rest_dihedral(triangle, s));
  };
  see(t);
  for (int s = 0; s < 3; ++s)
    if (const Index n = sheet.mesh().neighbour(t, s); n != no_index) see(n);
  const Material& m = sheet.material(t);
  const bool beside_notch = sheet.is_near_notch(t) && m.friction.sliders.empty() && !couples(m);
  return fold < folded_back && (all || fold > element.crease_angle || beside_notch);
}

std::optional<EdgeAngles> make_edge_angles(const Sheet& sheet, Index t, const CurvatureOperator& op,
                                           const BendingElement& bending) {
  constexpr double round_off = 1e-9;
  // Around an inner vertex of a curved rest shape edges are one too many for one unfolding: what only tells its defect is left out.
  constexpr double threshold = 1e-3, defect = 1e-2;
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  const Eigen::MatrixX3d weights = weights_of(op, bending.points);
  const mesh::Patch patch = sheet.patches().patch(t, sheet.frame(t));
  Hinges tree(sheet, bending.points);
  tree.add(t);
  for (int s = 0; s < 3; ++s)
    if (const Index n = mesh.neighbour(t, s); n != no_index && tree.has(patch.points[3 + static_cast<std::size_t>(s)]))
      tree.add(n);
  if (std::optional<EdgeAngles> angles = tree.making_up(weights, 0.0, round_off)) return angles;
  std::set<Index> inside;
  for (const Index p : bending.points) {
    if (p >= mesh.vertex_count()) continue;
    for (const Index n : mesh.triangles_of_vertex(p)) {
      const mesh::Triangle& corners = mesh.triangles()[n];
      if (std::all_of(corners.begin(), corners.end(), [&](Index v) { return tree.has(v); })) inside.insert(n);
    }
  }
  Hinges all(sheet, bending.points);
  for (const Index n : inside) all.add(n);
  if (!all.even()) return {};
  return all.making_up(weights, threshold, defect);
}

}  // namespace voile::energy

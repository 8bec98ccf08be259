#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "base/decompositions.hpp"
#include "base/unions.hpp"
#include "free_slopes.hpp"
#include "joint.hpp"
#include "voile/errors.hpp"

namespace voile::energy {

namespace {

/// Joints of each triangle that has some, without clamped ones.
std::map<Index, std::vector<Index>> joints_by_triangle(const Sheet& sheet) {
  std::map<Index, std::vector<Index>> of;
  const std::vector<mesh::Joint>& joints = sheet.mesh().joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const std::vector<mesh::TriangleSide>& sides = joints[j].sides;
    const auto is_free = [&](const mesh::TriangleSide& s) {
      return sheet.patches().apex(s.triangle, s.side) == no_index;
    };
    if (!std::all_of(sides.begin(), sides.end(), is_free)) continue;
    for (const mesh::TriangleSide& s : sides) of[s.triangle].push_back(static_cast<Index>(j));
  }
  return of;
}

class ClusterBuilder {
 public:
  ClusterBuilder(const Sheet& sheet, CurvatureBuilder& curvatures, const JointStiffness& stiffness)
      : sheet_(sheet), curvatures_(curvatures), stiffness_(stiffness) {}

  JointElement run(const std::vector<Index>& cluster) {
    for (const Index j : cluster) add_joint(j);
    write_vectors();
    take_rest();
    solve(static_cast<Eigen::Index>(cluster.size()));
    return std::move(el_);
  }

 private:
  using Row = std::map<Index, double>;
  struct Side {
    Index triangle;
    Eigen::Index row;  ///< among the free sides of the triangle
    int joint;
    double give;         ///< 1 / (2 k l) of a hinge, 0 elsewhere [1/(N m)]
    double factor;       ///< of the energy that it stores
    double sense = 1.0;  ///< sigma
  };

  void add_joint(Index number) {
    const mesh::Joint& joint = sheet_.mesh().joints()[static_cast<std::size_t>(number)];
    const double stiffness =
        2.0 * stiffness_.hinges[static_cast<std::size_t>(number)] * sheet_.mesh().rest_length(joint.edge);
    const int edge = static_cast<int>(rows_.size());
    rows_.push_back({{joint.edge[0], -1.0}, {joint.edge[1], 1.0}});
    for (const mesh::TriangleSide& s : joint.sides) {
      const FreeSlopes& slopes = slopes_of(s.triangle);
      const Eigen::Index k = slopes.row(s.side);
      const CurvatureOperator& op = slopes.of.operator_;
      const Eigen::RowVectorXd w = -slopes.natural.row(k) * op.weights;
      Row row;
      for (std::size_t i = 0; i < op.points.size(); ++i) row[op.points[i]] = w[static_cast<Eigen::Index>(i)];
      el_.angles.push_back(
          {s.triangle, edge, edge + 1, static_cast<int>(rows_.size()), 0.0, number, 0.0, Vec3::Zero()});
      sides_.push_back({s.triangle, k, joints_, 1.0 / stiffness, stiffness_.factors[static_cast<std::size_t>(number)]});
      rows_.push_back(std::move(row));
    }
    ++joints_;
  }

  const FreeSlopes& slopes_of(Index t) {
    const auto found = slopes_.find(t);
    if (found != slopes_.end()) return found->second;
    if (couples(sheet_.material(t))) {
      const Vec3 x = sheet_.mesh().start_corner(t, 0);
      throw UserError(
          fmt::format("[[material]]: an unsymmetric laminate ends at a hinge or a joint of sheets near "
                      "({:.4g}, {:.4g}, "
                      "{:.4g}) m; give the sheets that meet there a symmetric one",
                      x[0], x[1], x[2]));
    }
    return slopes_.emplace(t, FreeSlopes(sheet_, curvatures_, t)).first->second;
  }

  void write_vectors() {
    std::map<Index, Eigen::Index> column;
    for (const Row& row : rows_)
      for (const auto& entry : row) column.emplace(entry.first, 0);
    for (auto& [point, at] : column) {
      at = static_cast<Eigen::Index>(el_.points.size());
      el_.points.push_back(point);
    }
    el_.weights.setZero(static_cast<Eigen::Index>(rows_.size()), static_cast<Eigen::Index>(column.size()));
    el_.start.setZero(el_.weights.rows(), 3);
    const Vec3 origin = sheet_.patches().start(el_.points.front());  // keeps round-off small
    for (std::size_t r = 0; r < rows_.size(); ++r)
      for (const auto& [point, w] : rows_[r]) {
        el_.weights(static_cast<Eigen::Index>(r), column.at(point)) = w;
        el_.start.row(static_cast<Eigen::Index>(r)) += w * (sheet_.patches().start(point) - origin).transpose();
      }
  }

  /// Charts are flat, and lie on one of two sides of the edge.
  void take_rest() {
    const mesh::SurfaceMesh& mesh = sheet_.mesh();
    for (std::size_t n = 0; n < el_.angles.size(); ++n) {
      JointElement::Angle& a = el_.angles[n];
      const auto& sides = mesh.joints()[static_cast<std::size_t>(a.joint)].sides;
      const mesh::TriangleSide own = *std::find_if(sides.begin(), sides.end(), [&](const mesh::TriangleSide& s) {
        return s.triangle == a.triangle && slopes_.at(a.triangle).row(s.side) == sides_[n].row;
      });
      // Of the first sheet by the angle to the next one, which falls as it turns.
      const bool first = a.vector == a.reference;
      const int other = first ? a.vector + 1 : a.vector;
      const auto z = [&](int row) -> Vec3 { return el_.start.row(row); };
      const EdgePoints x{Vec3::Zero(), z(a.edge), z(a.reference), z(other)};
      const double slope = edge_angle_slopes(x)[first ? 2 : 3].dot(mesh.rest_normal(a.triangle));
      sides_[n].sense = mesh.has_charts() ? sense_of(own) : (slope > 0.0) == first ? -1.0 : 1.0;
      if (!first) {
        const bool is_flat = mesh.is_folded(own) != mesh.is_folded(sides.front());
        a.rest = !mesh.has_charts() ? edge_angle(x) : is_flat ? 0.0 : std::numbers::pi;
        a.fold = sides_[n].sense;
      }
      a.natural = sides_[n].sense * slopes_.at(a.triangle).natural.row(sides_[n].row).transpose();
    }
  }

  /// sigma: whether the triangle runs along the edge as the joint does.
  [[nodiscard]] double sense_of(const mesh::TriangleSide& s) const {
    const mesh::Triangle& v = sheet_.mesh().triangles()[static_cast<std::size_t>(s.triangle)];
    return v[static_cast<std::size_t>((s.side + 1) % 3)] < v[static_cast<std::size_t>((s.side + 2) % 3)] ? 1.0 : -1.0;
  }

  void solve(Eigen::Index joints) {
    const auto count = static_cast<Eigen::Index>(sides_.size());
    Eigen::MatrixXd edges = Eigen::MatrixXd::Zero(joints, joints), mixed = Eigen::MatrixXd::Zero(joints, count),
                    angles = Eigen::MatrixXd::Zero(count, count);
    std::map<Index, std::vector<Eigen::Index>> of_triangle;
    for (Eigen::Index n = 0; n < count; ++n) of_triangle[side(n).triangle].push_back(n);
    std::map<Index, Eigen::MatrixXd> stiffness;
    for (const auto& [t, on] : of_triangle) {
      const Eigen::MatrixXd c = joint_stiffness(t, on);
      for (std::size_t i = 0; i < on.size(); ++i)
        for (std::size_t j = 0; j < on.size(); ++j) {
          const Side &p = side(on[i]), &q = side(on[j]);
          const double k = p.sense * q.sense * c(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
          edges(p.joint, q.joint) += k;
          mixed(p.joint, on[j]) -= k;
          angles(on[i], on[j]) += k;
        }
      stiffness.emplace(t, c);
    }
    const Eigen::MatrixXd turn = -solve_positive(edges, mixed);  // theta of psi
    el_.stiffness = angles + mixed.transpose() * turn;
    el_.stiffness = 0.5 * (el_.stiffness + el_.stiffness.transpose().eval());
    for (const auto& [t, on] : of_triangle) {
      const FreeSlopes& slopes = slopes_.at(t);
      Eigen::MatrixXd change(static_cast<Eigen::Index>(on.size()), count),
          of_joints(slopes.compliance.rows(), change.rows());
      for (std::size_t i = 0; i < on.size(); ++i) {
        const Side& s = side(on[i]);
        const auto r = static_cast<Eigen::Index>(i);
        change.row(r) = s.sense * turn.row(s.joint);
        change(r, on[i]) -= s.sense;
        of_joints.col(r) = slopes.compliance.col(s.row);
      }
      el_.bends.push_back({t, slopes.across * of_joints * stiffness.at(t) * change});
    }
  }
  [[nodiscard]] const Side& side(Eigen::Index n) const { return sides_[static_cast<std::size_t>(n)]; }

  /// C_J.
  [[nodiscard]] Eigen::MatrixXd joint_stiffness(Index t, const std::vector<Eigen::Index>& on) const {
    const auto n = static_cast<Eigen::Index>(on.size());
    Eigen::MatrixXd compliance(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        compliance(i, j) = slopes_.at(t).compliance(side(on[static_cast<std::size_t>(i)]).row,
                                                    side(on[static_cast<std::size_t>(j)]).row);
    for (Eigen::Index i = 0; i < n; ++i) compliance(i, i) += side(on[static_cast<std::size_t>(i)]).give;
    Eigen::MatrixXd c = inverse(compliance);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        c(i, j) *=
            std::sqrt(side(on[static_cast<std::size_t>(i)]).factor * side(on[static_cast<std::size_t>(j)]).factor);
    return c;
  }

  const Sheet& sheet_;
  CurvatureBuilder& curvatures_;
  const JointStiffness& stiffness_;
  JointElement el_;
  std::map<Index, FreeSlopes> slopes_;
  std::vector<Row> rows_;
  std::vector<Side> sides_;
  int joints_ = 0;
};

}  // namespace

std::vector<std::vector<Index>> joint_clusters(const Sheet& sheet) {
  const std::size_t count = sheet.mesh().joints().size();
  Unions together(count);
  std::vector<char> acts(count, 0);
  for (const auto& entry : joints_by_triangle(sheet))
    for (const Index j : entry.second) {
      acts[j] = 1;
      together.join(j, entry.second.front());
    }
  std::map<Index, std::vector<Index>> members;
  for (Index j = 0; j < static_cast<Index>(count); ++j)
    if (acts[j]) members[together.find(j)].push_back(j);
  std::vector<std::vector<Index>> clusters;
  for (const auto& entry : members)
    if (entry.second.size() <= most_joints)
      clusters.push_back(entry.second);
    else
      for (const Index j : entry.second) clusters.push_back({j});
  return clusters;
}

JointElement make_joint_element(const Sheet& sheet, CurvatureBuilder& curvatures, const std::vector<Index>& cluster,
                                const JointStiffness& stiffness) {
  return ClusterBuilder(sheet, curvatures, stiffness).run(cluster);
}

}  // namespace voile::energy

#include "rigid_motions.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/decompositions.hpp"
#include "base/unions.hpp"

namespace voile::system {

namespace {

/// Singular values below this fraction of the largest count as zero: supports that deviate so little from letting a motion
/// free do not hold it.
constexpr double rank_tolerance = 1e-7;

/// What moves as one rigid body: triangles connected through edges.
struct Body {
  Vec3 centre = Vec3::Zero();
  double radius = 0.0;  ///< of gyration
  Index triangles = 0, vertices = 0, column = 0;
};

/// An orthonormal basis of the columns' span that keeps to the global axes where it can: projections of these, the
/// longest first.
std::vector<Vec3> tidy_axes(const Eigen::MatrixXd& columns) {
  std::vector<Vec3> axes;
  if (columns.cols() == 0) return axes;
  Mat3 projector = Mat3::Zero();
  const SingularValues svd = singular_value_decomposition(columns);
  for (Eigen::Index k = 0; k < svd.values.size(); ++k)
    if (svd.values[k] > 1e-6) projector += svd.u.col(k) * svd.u.col(k).transpose();
  while (projector.trace() > 0.5) {
    Eigen::Index longest = 0;
    projector.diagonal().maxCoeff(&longest);
    axes.push_back(projector.col(longest).normalized());
    projector -= axes.back() * axes.back().transpose();
  }
  return axes;
}

class Counter {
 public:
  Counter(const mesh::SurfaceMesh& mesh, const Constraints& constraints, const std::vector<Spring>& springs)
      : mesh_(mesh),
        constraints_(constraints),
        springs_(springs),
        triangle_body_(static_cast<std::size_t>(mesh.triangle_count())) {
    find_bodies();
    join_bodies();
  }

  std::vector<FreePiece> count() {
    std::vector<FreePiece> free;
    for (const std::vector<Index>& group : groups_) {
      const FreePiece piece = count(group);
      if (piece.motions() > 0) free.push_back(piece);
    }
    return free;
  }

 private:
  using Matrix = Eigen::MatrixXd;

  void find_bodies() {
    Unions connected(triangle_body_.size());
    for (Index t = 0; t < mesh_.triangle_count(); ++t)
      for (int s = 0; s < 3; ++s)
        if (const Index n = mesh_.neighbour(t, s); n != no_index) connected.join(t, n);
    for (const mesh::Joint& j : mesh_.joints())
      for (const mesh::TriangleSide& s : j.sides) connected.join(s.triangle, j.sides.front().triangle);
    std::map<Index, Index> number;
    for (Index t = 0; t < mesh_.triangle_count(); ++t) {
      const auto at = number.emplace(connected.find(t), static_cast<Index>(number.size())).first;
      triangle_body_[t] = at->second;
    }
    bodies_.resize(number.size());
    for (const Index b : triangle_body_) ++bodies_[b].triangles;
    each_vertex([&](Index v, Index b) {
      bodies_[b].centre += mesh_.positions()[v];
      ++bodies_[b].vertices;
    });
    for (Body& b : bodies_) b.centre /= b.vertices;
    each_vertex(
        [&](Index v, Index b) { bodies_[b].radius += (mesh_.positions()[v] - bodies_[b].centre).squaredNorm(); });
    for (Body& b : bodies_) b.radius = std::sqrt(b.radius / b.vertices);
  }

  /// Bodies around a vertex, each once: usually one.
  [[nodiscard]] std::vector<Index> bodies_of(Index v) const {
    std::vector<Index> found;
    for (const Index t : mesh_.triangles_of_vertex(v)) found.push_back(triangle_body_[t]);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  template <class Work>
  void each_vertex(const Work& work) const {
    for (Index v = 0; v < mesh_.vertex_count(); ++v)
      for (const Index b : bodies_of(v)) work(v, b);
  }

  /// Every vertex that a spring holds, with each direction in which it does.
  template <class Work>
  void each_spring(const Work& work) const {
    for (const Spring& s : springs_) {
      if (s.kind == Spring::Kind::pair || s.kind == Spring::Kind::band) continue;
      const auto at = [&](Index v) {
        if (s.direction) return work(v, s.direction->normalized());
        for (int k = 0; k < 3; ++k) work(v, Vec3::Unit(k));
      };
      if (!s.group.empty())
        for (const Index v : mesh_.group(s.group).vertices) at(v);
      else
        for (Index v = 0; v < mesh_.vertex_count(); ++v) at(v);
    }
  }

  void join_bodies() {
    Unions touching(bodies_.size());
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      const std::vector<Index> here = bodies_of(v);
      for (std::size_t k = 1; k < here.size(); ++k) {
        touching.join(here[0], here[k]);
        joints_.push_back({v, here[0], here[k]});
      }
    }
    for (const RigidBody& rigid : constraints_.bodies) {
      const Index first = bodies_of(rigid.members.front()).front();
      for (const Index v : rigid.members) {
        in_rigid_.insert(v);
        for (const Index other : bodies_of(v)) {
          if (other == first) continue;
          touching.join(first, other);
          joints_.push_back({v, first, other});
        }
      }
    }
    for (const Index v : constraints_.ties.carriers)
      touching.join(bodies_of(v).front(), bodies_of(constraints_.ties.root(v)).front());
    for (const Spring& s : springs_)
      for (const auto& [v, w] : pairs_of(mesh_, s)) {
        const Index first = bodies_of(v).front(), second = bodies_of(w).front();
        touching.join(first, second);
        ties_.push_back({v, w, first, second, s.length != 0.0});
      }
    std::map<Index, std::vector<Index>> members;
    for (Index b = 0; b < static_cast<Index>(bodies_.size()); ++b) members[touching.find(b)].push_back(b);
    for (const auto& entry : members) {
      for (std::size_t k = 0; k < entry.second.size(); ++k) bodies_[entry.second[k]].column = static_cast<Index>(6 * k);
      groups_.push_back(entry.second);
    }
  }

  /// Row of d . u(X_v) of one body.
  void add_held(Matrix& row, Index body, Index v, const Vec3& d, double sign = 1.0) const {
    const Body& b = bodies_[body];
    row.block<1, 3>(0, b.column) += sign * d.transpose();
    row.block<1, 3>(0, b.column + 3) += sign * ((mesh_.positions()[v] - b.centre) / b.radius).cross(d).transpose();
  }

  /// What holds the reference point of a rigid group, which moves with one of its pieces.
  template <class Finish>
  void add_rigid(const RigidBody& rigid, Index body, Matrix& row, const Finish& finish) const {
    const Body& b = bodies_[body];
    const std::array<bool, 3>&held = constraints_.vertices.at(rigid.carriers[0]).fixed,
                           &turn = constraints_.vertices.at(rigid.carriers[1]).fixed;
    for (int k = 0; k < 3; ++k) {
      if (held[static_cast<std::size_t>(k)]) {
        row.setZero();
        row.block<1, 3>(0, b.column) = Vec3::Unit(k).transpose();
        row.block<1, 3>(0, b.column + 3) = ((rigid.point - b.centre) / b.radius).cross(Vec3(Vec3::Unit(k))).transpose();
        finish();
      }
      if (turn[static_cast<std::size_t>(k)]) {
        row.setZero();
        row.block<1, 3>(0, b.column + 3) = rigid.basis.col(k).transpose();
        finish();
      }
    }
  }

  /// The components of a difference that are prescribed.
  template <class Finish>
  void add_difference(Index carrier, Matrix& row, const Finish& finish) const {
    const std::array<bool, 3>& held = constraints_.vertices.at(carrier).fixed;
    const Index root = constraints_.ties.root(carrier);
    for (int k = 0; k < 3; ++k) {
      if (!held[static_cast<std::size_t>(k)]) continue;
      row.setZero();
      add_held(row, bodies_of(carrier).front(), carrier, Vec3::Unit(k));
      add_held(row, bodies_of(root).front(), root, Vec3::Unit(k), -1.0);
      finish();
    }
  }

  /// What joins bodies to each other: vertices in common, and springs.
  template <class Inside, class Finish>
  void add_connections(const Inside& inside, Matrix& row, const Finish& finish) const {
    for (const Joint& joint : joints_) {
      if (!inside(joint.first)) continue;
      for (int k = 0; k < 3; ++k) {
        row.setZero();
        add_held(row, joint.first, joint.vertex, Vec3::Unit(k));
        add_held(row, joint.second, joint.vertex, Vec3::Unit(k), -1.0);
        finish();
      }
    }
    for (const Tie& tie : ties_) {
      if (!inside(tie.first)) continue;
      const Vec3 between = mesh_.positions()[tie.to] - mesh_.positions()[tie.from];
      const bool directed = tie.directed && between.squaredNorm() > 0.0;
      for (int k = 0; k < (directed ? 1 : 3); ++k) {
        const Vec3 d = directed ? Vec3(between.normalized()) : Vec3(Vec3::Unit(k));
        row.setZero();
        add_held(row, tie.first, tie.from, d);
        add_held(row, tie.second, tie.to, d, -1.0);
        finish();
      }
    }
  }

  /// Adds the outer product of each equation to the normal matrix, divided by their number so that many do not hide
  /// few.
  [[nodiscard]] Matrix normal_matrix(const std::vector<Index>& group) const {
    const auto n = static_cast<Eigen::Index>(6 * group.size());
    Matrix stacked = Matrix::Zero(n, n), row(1, n);
    const auto inside = [&](Index body) { return std::binary_search(group.begin(), group.end(), body); };
    const auto finish = [&] { stacked += row.transpose() * row; };
    for (const RigidBody& rigid : constraints_.bodies) {
      const Index body = bodies_of(rigid.members.front()).front();
      if (inside(body)) add_rigid(rigid, body, row, finish);
    }
    for (const auto& [v, support] : constraints_.vertices) {
      const Index body = bodies_of(v).front();
      if (!inside(body) || in_rigid_.count(v) > 0 || (constraints_.ties.any() && constraints_.ties.is_tied(v)))
        continue;
      for (int k = 0; k < 3; ++k) {
        if (!support.fixed[k]) continue;
        row.setZero();
        add_held(row, body, v, support.axes.col(k));
        finish();
      }
    }
    for (const Index v : constraints_.ties.carriers) {
      if (!inside(bodies_of(v).front())) continue;
      add_difference(v, row, finish);
    }
    each_spring([&](Index v, const Vec3& d) {
      const Index body = bodies_of(v).front();
      if (!inside(body)) return;
      row.setZero();
      add_held(row, body, v, d);
      finish();
    });
    const auto hold_slope = [&](Index t, int s) {
      if (!inside(triangle_body_[t])) return;
      row.setZero();
      row.block<1, 3>(0, bodies_[triangle_body_[t]].column + 3) =
          (mesh_.start_corner(t, (s + 2) % 3) - mesh_.start_corner(t, (s + 1) % 3)).normalized().transpose();
      finish();
    };
    for (const mesh::MirrorSide& m : constraints_.mirrors) hold_slope(m.triangle, m.side);
    for (const mesh::TriangleSide& side : constraints_.elastic) hold_slope(side.triangle, side.side);
    add_connections(inside, row, finish);
    return stacked;
  }

  [[nodiscard]] FreePiece count(const std::vector<Index>& group) const {
    FreePiece piece;
    Index vertices = 0;
    for (const Index b : group) {
      piece.triangles += bodies_[b].triangles;
      piece.centre += bodies_[b].vertices * bodies_[b].centre;
      vertices += bodies_[b].vertices;
    }
    piece.centre /= vertices;
    const Spectrum modes = spectrum(normal_matrix(group));
    // Eigenvalues are squares of the singular values of the equations. A unit row counts at least 1 in the trace.
    const double limit = std::max(1.0, modes.values.maxCoeff()) * rank_tolerance * rank_tolerance;
    Eigen::Index free = 0;
    while (free < modes.values.size() && modes.values[free] <= limit) ++free;
    if (free == 0) return piece;
    // Rotations among the free motions; the rest are translations.
    const Matrix motions = modes.vectors.leftCols(free);
    Matrix turning(static_cast<Eigen::Index>(3 * group.size()), free);
    for (std::size_t k = 0; k < group.size(); ++k)
      turning.middleRows(static_cast<Eigen::Index>(3 * k), 3) =
          motions.middleRows(static_cast<Eigen::Index>(6 * k + 3), 3);
    const SingularValues svd = singular_value_decomposition(turning);
    while (piece.rotations < svd.values.size() && svd.values[piece.rotations] > 1e-6) ++piece.rotations;
    piece.translations = static_cast<int>(free) - piece.rotations;
    const Matrix drifts = motions * svd.v.rightCols(piece.translations);
    piece.directions = tidy_axes(drifts.middleRows(bodies_[group.front()].column, 3));
    return piece;
  }

  struct Joint {
    Index vertex, first, second;
  };
  struct Tie {  ///< a spring between two vertices; without a length it holds all components together
    Index from, to, first, second;
    bool directed;
  };

  const mesh::SurfaceMesh& mesh_;
  const Constraints& constraints_;
  const std::vector<Spring>& springs_;
  std::vector<Index> triangle_body_;
  std::vector<Body> bodies_;
  std::vector<std::vector<Index>> groups_;  ///< bodies that share vertices, ascending
  std::vector<Joint> joints_;
  std::set<Index> in_rigid_;  ///< vertices of rigid groups
  std::vector<Tie> ties_;
};

}  // namespace

std::vector<FreePiece> free_pieces(const mesh::SurfaceMesh& mesh, const Constraints& constraints,
                                   const std::vector<Spring>& springs) {
  return Counter(mesh, constraints, springs).count();
}

}  // namespace voile::system

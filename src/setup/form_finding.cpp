#include "form_finding.hpp"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace voile::setup {

namespace {

/// The first `count` columns are orthonormal, the others zero.
struct Directions {
  Mat3 columns = Mat3::Zero();
  Eigen::Index count = 0;
  void add(const Vec3& direction) { columns.col(count++) = direction; }
};

/// A triangle of less than this fraction of its first area, or of its first height over its longest side, has collapsed.
constexpr double least_area = 1e-6, least_height = 0.01;
/// Cosine between the normals of two neighbours beyond which the surface has folded onto itself.
constexpr double folded = 0.0;
/// Steps in which vertices move within the surface too, which spaces them evenly, at the beginning and where that is needed: so many
/// at least, and on as long as each leaves less than this fraction of what is out of balance. A cable that moves far takes cells
/// along only so, else it crushes those beside it, and its steps shrink with them.
constexpr int free_steps = 3;
constexpr double free_fraction = 0.9;

class Search {
 public:
  explicit Search(const FormProblem& problem) : p_(problem), x_(problem.places) {
    for (const mesh::Triangle& t : p_.triangles) {
      areas_.push_back(0.5 * twice_area(t).norm());
      heights_.push_back(height(t));
    }
    find_sides();
  }

  FormResult run() {
    FormResult r;
    for (int free = free_steps;; ++r.iterations, --free) {
      r.collapsed = assemble();
      if (r.collapsed != no_index) break;
      find_directions(true);
      const double before = std::exchange(r.within, residual());
      if (free == 1 && r.within < free_fraction * before) ++free;
      if (free <= 0) find_directions(false);
      r.residual = free > 0 ? r.within : residual();
      const bool done = free <= 0 && r.residual <= p_.tolerance;
      r.converged = done && r.within <= p_.within;
      if (r.converged || r.iterations == p_.most_iterations || !std::isfinite(r.residual)) break;
      if (done) {
        free = free_steps;
        find_directions(true);
        r.residual = residual();
      }
      if (!move()) break;
    }
    if (r.converged) r.collapsed = fold();
    r.converged = r.converged && r.collapsed == no_index;
    r.places = x_;
    return r;
  }

 private:
  [[nodiscard]] const Vec3& place(Index v) const { return x_[static_cast<std::size_t>(v)]; }
  [[nodiscard]] Vec3 twice_area(const mesh::Triangle& t) const {
    return (place(t[1]) - place(t[0])).cross(place(t[2]) - place(t[0]));
  }

  /// Over the longest side.
  [[nodiscard]] double height(const mesh::Triangle& t) const {
    double longest = 0.0;
    for (std::size_t s = 0; s < 3; ++s)
      longest = std::max(longest, (place(t[s]) - place(t[(s + 1) % 3])).squaredNorm());
    return twice_area(t).norm() / longest;
  }

  /// Edges of one triangle, or of three and more, are curves: vertices there move across them too.
  void find_sides() {
    std::map<mesh::Segment, std::vector<Index>> sides;
    for (std::size_t t = 0; t < p_.triangles.size(); ++t)
      for (std::size_t s = 0; s < 3; ++s) {
        const Index a = p_.triangles[t][s], b = p_.triangles[t][(s + 1) % 3];
        sides[{std::min(a, b), std::max(a, b)}].push_back(static_cast<Index>(t));
      }
    curve_ends_.assign(x_.size(), {});
    for (const auto& [edge, of] : sides) {
      if (of.size() == 2) {
        if (turn(of[0], of[1]) > folded) neighbours_.emplace_back(of[0], of[1]);
        continue;
      }
      curve_ends_[static_cast<std::size_t>(edge[0])].push_back(edge[1]);
      curve_ends_[static_cast<std::size_t>(edge[1])].push_back(edge[0]);
    }
  }

  /// Cosine between the normals of two triangles.
  [[nodiscard]] double turn(Index s, Index t) const {
    return twice_area(p_.triangles[static_cast<std::size_t>(s)])
        .normalized()
        .dot(twice_area(p_.triangles[static_cast<std::size_t>(t)]).normalized());
  }

  /// A triangle that has folded onto its neighbour, if any.
  [[nodiscard]] Index fold() const {
    for (const auto& [s, t] : neighbours_)
      if (!(turn(s, t) > folded)) return s;
    return no_index;
  }

  /// What moves each vertex: all that is free, or of that what changes the shape.
  void find_directions(bool all) {
    std::vector<Vec3> normals(x_.size(), Vec3::Zero());
    for (const mesh::Triangle& t : p_.triangles)
      for (const Index v : t) normals[static_cast<std::size_t>(v)] += twice_area(t);
    first_.assign(x_.size() + 1, 0);
    directions_.resize(x_.size());
    for (std::size_t v = 0; v < x_.size(); ++v) {
      directions_[v] = directions_at(v, normals[v], all);
      first_[v + 1] = first_[v] + directions_[v].count;
    }
  }

  [[nodiscard]] Directions directions_at(std::size_t v, const Vec3& normal, bool all) const {
    Vec3 free;
    for (Eigen::Index k = 0; k < 3; ++k) free[k] = p_.held[v][static_cast<std::size_t>(k)] ? 0.0 : 1.0;
    Directions d;
    const std::vector<Index>& ends = curve_ends_[v];
    const bool is_on_curve = ends.size() == 2;
    if (all || ends.size() == 1 || ends.size() > 2) {
      for (int k = 0; k < 3; ++k)
        if (free[k] > 0.0) d.add(Vec3::Unit(k));
      return d;
    }
    constexpr double least = 1e-6;  // of a unit vector: it is held
    const auto add_free = [&](Vec3 direction) {
      direction = direction.cwiseProduct(free);
      direction -= d.columns * (d.columns.transpose() * direction);
      if (direction.norm() > least) d.add(direction.normalized());
    };
    if (!is_on_curve) {
      add_free(normal.normalized());
      return d;
    }
    const Vec3 along = (place(ends[0]) - place(ends[1])).normalized();
    for (int k = 0; k < 3; ++k) {
      Vec3 across = Vec3::Unit(k).cwiseProduct(free);
      const Vec3 tangent = along.cwiseProduct(free);
      if (tangent.norm() > least) across -= across.dot(tangent) / tangent.squaredNorm() * tangent;
      if (across.norm() > least) add_free(across.normalized());
    }
    return d;
  }

  void add(Index i, Index j, double value) {
    entries_.emplace_back(i, j, value);
    if (i != j) entries_.emplace_back(j, i, value);
  }

  /// K and f; the triangle that has collapsed, if any.
  [[nodiscard]] Index assemble() {
    entries_.clear();
    load_.assign(x_.size(), Vec3::Zero());
    for (std::size_t t = 0; t < p_.triangles.size(); ++t) {
      const mesh::Triangle& v = p_.triangles[t];
      const Vec3 twice = twice_area(v);
      if (!(0.5 * twice.norm() > least_area * areas_[t] && height(v) > least_height * heights_[t]))
        return static_cast<Index>(t);
      const std::array<Vec3, 3> c{place(v[0]), place(v[1]), place(v[2])};
      const Mat3 force = p_.force(static_cast<Index>(t), c);
      std::array<Vec3, 3> g;
      for (std::size_t i = 0; i < 3; ++i) g[i] = twice.cross(c[(i + 2) % 3] - c[(i + 1) % 3]) / twice.squaredNorm();
      for (std::size_t i = 0; i < 3; ++i) {
        load_[static_cast<std::size_t>(v[i])] += p_.pressure / 6.0 * twice;
        for (std::size_t j = i; j < 3; ++j) add(v[i], v[j], 0.5 * twice.norm() * g[i].dot(force * g[j]));
      }
    }
    for (const FormProblem::Cable& cable : p_.cables) {
      const auto [a, b] = cable.edge;
      const double density = cable.force / (place(a) - place(b)).norm();
      add(a, a, density);
      add(b, b, density);
      add(a, b, -density);
    }
    return no_index;
  }

  /// f - K x along the directions, in `right_`; the largest of it over the largest sum of the sizes of forces at a vertex.
  [[nodiscard]] double residual() {
    std::vector<Vec3> out = load_;
    std::vector<double> sizes(x_.size(), 0.0);
    for (const auto& e : entries_) {
      if (e.row() == e.col()) continue;
      const Vec3 force = e.value() * (place(e.row()) - place(e.col()));  // rows of K sum to zero
      out[static_cast<std::size_t>(e.row())] += force;
      sizes[static_cast<std::size_t>(e.row())] += force.norm();
    }
    right_.resize(first_.back());
    for (std::size_t v = 0; v < x_.size(); ++v) {
      const Vec3 along = directions_[v].columns.transpose() * out[v];
      for (Eigen::Index k = 0; k < directions_[v].count; ++k) right_[first_[v] + k] = along[k];
    }
    const double largest = *std::max_element(sizes.begin(), sizes.end());
    return right_.size() > 0 ? right_.cwiseAbs().maxCoeff() / largest : 0.0;
  }

  /// Solves K along the directions. False if it is not positive definite.
  [[nodiscard]] bool move() {
    std::vector<Eigen::Triplet<double>> blocks;
    for (const auto& e : entries_) {
      const auto i = static_cast<std::size_t>(e.row()), j = static_cast<std::size_t>(e.col());
      const Mat3 block = e.value() * (directions_[i].columns.transpose() * directions_[j].columns);
      for (Eigen::Index k = 0; k < directions_[i].count; ++k)
        for (Eigen::Index l = 0; l < directions_[j].count; ++l)
          blocks.emplace_back(first_[i] + k, first_[j] + l, block(k, l));
    }
    Eigen::SparseMatrix<double, 0, Eigen::Index> matrix(first_.back(), first_.back());
    matrix.setFromTriplets(blocks.begin(), blocks.end());
    const Eigen::SimplicialLDLT<decltype(matrix)> factor(matrix);
    if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0.0)) return false;
    const Eigen::VectorXd step = factor.solve(right_);
    for (std::size_t v = 0; v < x_.size(); ++v)
      for (Eigen::Index k = 0; k < directions_[v].count; ++k)
        x_[v] += step[first_[v] + k] * directions_[v].columns.col(k);
    return true;
  }

  const FormProblem& p_;
  std::vector<Vec3> x_, load_;
  std::vector<double> areas_, heights_;
  std::vector<std::pair<Index, Index>> neighbours_;  ///< that do not lie on each other at the start
  std::vector<std::vector<Index>> curve_ends_;
  std::vector<Directions> directions_;
  std::vector<Eigen::Index> first_;  ///< unknown of each vertex
  std::vector<Eigen::Triplet<double, Index>> entries_;
  Eigen::VectorXd right_;
};

}  // namespace

FormResult find_form(const FormProblem& problem) {
  return Search(problem).run();
}

}  // namespace voile::setup

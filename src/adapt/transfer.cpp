#include "transfer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "develop.hpp"
#include "features.hpp"
#include "voile/errors.hpp"

namespace voile::adapt {

namespace {

using Gradient = Eigen::Matrix<double, 3, 2>;
using Weights = std::array<double, 3>;

/// Clough-Tocher's triangle of three cubics with normal slopes that are linear along the sides, at barycentric weights.
Vec3 clough_tocher(const std::array<Vec2, 3>& x, const std::array<Vec3, 3>& f, const std::array<Gradient, 3>& g,
                   const Weights& w) {
  const Vec2 centre = (x[0] + x[1] + x[2]) / 3.0;
  // Bezier ordinates: beside corner i towards corner j, and towards the centre; in the middle of the part beside side k.
  const auto towards = [&](std::size_t i, const Vec2& to) { return Vec3(f[i] + g[i] * (to - x[i]) / 3.0); };
  std::array<Vec3, 3> inward, middle, second;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    inward[k] = towards(k, centre);
    const Vec2 side = x[j] - x[i], across(side.y(), -side.x());
    // `across` in barycentric directions of the part (i, j, centre).
    const Vec2 to_centre = centre - x[i];
    const double area = side.x() * to_centre.y() - side.y() * to_centre.x();
    const double dj = (across.x() * to_centre.y() - across.y() * to_centre.x()) / area;
    const double dc = (side.x() * across.y() - side.y() * across.x()) / area;
    const double di = -dj - dc;
    middle[k] = ((g[i] + g[j]) * across / 6.0 - di * towards(i, x[j]) - dj * towards(j, x[i])) / dc;
  }
  for (std::size_t k = 0; k < 3; ++k) second[k] = (inward[k] + middle[(k + 1) % 3] + middle[(k + 2) % 3]) / 3.0;
  const Vec3 top = (second[0] + second[1] + second[2]) / 3.0;
  const auto k = static_cast<std::size_t>(std::min_element(w.begin(), w.end()) - w.begin());
  const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
  const double a = w[i] - w[k], b = w[j] - w[k], c = 3.0 * w[k];
  return a * a * a * f[i] + b * b * b * f[j] + c * c * c * top + 3.0 * a * a * b * towards(i, x[j]) +
         3.0 * a * b * b * towards(j, x[i]) + 3.0 * a * a * c * inward[i] + 3.0 * b * b * c * inward[j] +
         3.0 * a * c * c * second[i] + 3.0 * b * c * c * second[j] + 6.0 * a * b * c * middle[k];
}

class Interpolator {
 public:
  Interpolator(const mesh::SurfaceMesh& mesh, const std::vector<Vec3>& field, int degree)
      : mesh_(mesh),
        field_(field),
        degree_(degree),
        edges_(half_edges(mesh)),
        features_(find_features(mesh, edges_, {}, Options{}.crease)),
        slot_(static_cast<std::size_t>(mesh.triangle_count()), no_index) {}

  Vec3 operator()(const Remeshed::Source& at) {
    for (int s = 0; s < 3; ++s)
      if (at.weights[static_cast<std::size_t>(s)] == 0.0 && has_own_values(3 * at.triangle + s))
        return on_line(3 * at.triangle + s, at.weights[static_cast<std::size_t>((s + 2) % 3)]);
    Index& slot = slot_[at.triangle];
    if (slot == no_index) {
      slot = static_cast<Index>(gradients_.size());
      gradients_.emplace_back();
      for (int i = 0; i < 3; ++i)
        gradients_.back()[static_cast<std::size_t>(i)] = corner_gradient(mesh_, at.triangle, i, field_, degree_);
    }
    const mesh::Triangle& v = mesh_.triangles()[at.triangle];
    return clough_tocher(plane_of(mesh_, at.triangle), {field_[v[0]], field_[v[1]], field_[v[2]]}, gradients_[slot],
                         at.weights);
  }

 private:
  /// Boundaries and group lines, which may be held; seams and creases are like any other place.
  [[nodiscard]] bool has_own_values(Index h) const {
    return edges_.twin[h] == no_index || !features_.groups_of_side_class[features_.side_class[h]].empty();
  }
  [[nodiscard]] double length(Index h) const {
    const Index t = h / 3;
    return (mesh_.rest_corner(t, prev(h) % 3) - mesh_.rest_corner(t, next(h) % 3)).norm();
  }
  /// The side of the same line after h, or before it, with the same triangles to the left; no_index at corners.
  [[nodiscard]] Index after(Index h) const {
    if (features_.corner[edges_.dest(h)]) return no_index;
    Index e = next(h);
    while (features_.side_class[e] == 0) e = next(edges_.twin[e]);
    return e;
  }
  [[nodiscard]] Index before(Index h) const {
    if (features_.corner[edges_.origin(h)]) return no_index;
    Index e = prev(h);
    while (features_.side_class[e] == 0) e = prev(edges_.twin[e]);
    return e;
  }
  /// Such a line has its own cubic, from what is on it: what is equal along it, as the distance from a plane of symmetry,
  /// stays.
  [[nodiscard]] Vec3 on_line(Index h, double fraction) const {
    const Vec3 &a = field_[edges_.origin(h)], &b = field_[edges_.dest(h)];
    const double l = length(h);
    const Vec3 slope = (b - a) / l;
    const Index p = before(h), q = after(h);
    // Slopes at the ends of parabolas through three points; at a corner that of the parabola from the other end.
    Vec3 at_a = slope, at_b = slope;
    if (p != no_index && p != h) {
      const double lp = length(p);
      at_a = (l * (a - field_[edges_.origin(p)]) / lp + lp * slope) / (l + lp);
    }
    if (q != no_index && q != h) {
      const double lq = length(q);
      at_b = (l * (field_[edges_.dest(q)] - b) / lq + lq * slope) / (l + lq);
    }
    if (p == no_index && q != no_index) at_a = 2.0 * slope - at_b;
    if (q == no_index && p != no_index) at_b = 2.0 * slope - at_a;
    const double u = fraction, v = 1.0 - fraction;
    return v * v * (1.0 + 2.0 * u) * a + u * u * (1.0 + 2.0 * v) * b + l * (u * v * v * at_a - u * u * v * at_b);
  }

  const mesh::SurfaceMesh& mesh_;
  const std::vector<Vec3>& field_;
  int degree_;
  HalfEdges edges_;
  Features features_;
  std::vector<Index> slot_;
  std::vector<std::array<Gradient, 3>> gradients_;
};

Vec3 linear(const mesh::SurfaceMesh& mesh, const std::vector<Vec3>& field, const Remeshed::Source& at) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    if (at.weights[i] != 0.0) sum += at.weights[i] * field[mesh.triangles()[at.triangle][i]];
  return sum;
}

/// How far a smooth value may be from the linear one: this fraction of the largest difference between the corners of a
/// triangle and those opposite of them. A wave of eight edges needs a tenth; a field that jumps from vertex to vertex would
/// be made into peaks several times as high.
constexpr double most_beyond_linear = 0.25;

Vec3 limited(const mesh::SurfaceMesh& mesh, const std::vector<Vec3>& field, const Remeshed::Source& at,
             const Vec3& smooth) {
  std::vector<Vec3> around;
  for (Index v : mesh.triangles()[at.triangle]) around.push_back(field[v]);
  for (int s = 0; s < 3; ++s)
    if (const Index n = mesh.neighbour(at.triangle, s); n != no_index)
      around.push_back(field[mesh.triangles()[n][mesh.side_in_neighbour(at.triangle, s)]]);
  double difference = 0.0;
  for (std::size_t i = 0; i < around.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) difference = std::max(difference, (around[i] - around[j]).norm());
  const Vec3 plain = linear(mesh, field, at), beyond = smooth - plain;
  const double length = beyond.norm(), most = most_beyond_linear * difference;
  return length > most ? Vec3(plain + beyond * (most / length)) : smooth;
}

}  // namespace

std::vector<Vec3> transfer(const mesh::SurfaceMesh& old_mesh, const Remeshed& remeshed, const std::vector<Vec3>& field,
                           Interpolation kind) {
  if (field.size() != static_cast<std::size_t>(old_mesh.vertex_count()))
    throw InternalError("transfer: the field is not per vertex of the old mesh");
  std::vector<Vec3> result;
  result.reserve(remeshed.kept.size());
  // The gap of an open seam stays what it is: what is new there lies on the old sides.
  std::vector<char> sewn(remeshed.kept.size(), 0);
  for (const mesh::Seam& seam : remeshed.mesh.seams)
    for (const auto& [a, b] : seam.pairs) sewn[a] = sewn[b] = 1;
  Interpolator smooth(old_mesh, field, kind == Interpolation::smoother ? 3 : 2);
  for (std::size_t v = 0; v < remeshed.kept.size(); ++v) {
    if (remeshed.kept[v] != no_index)
      result.push_back(field[remeshed.kept[v]]);
    else if (kind == Interpolation::linear || sewn[v])
      result.push_back(linear(old_mesh, field, remeshed.source[v]));
    else
      result.push_back(kind == Interpolation::smooth
                           ? smooth(remeshed.source[v])
                           : limited(old_mesh, field, remeshed.source[v], smooth(remeshed.source[v])));
  }
  return result;
}

}  // namespace voile::adapt

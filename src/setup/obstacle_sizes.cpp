#include "obstacle_sizes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

#include "geometry/winding.hpp"

namespace voile::setup {

namespace {

/// Dihedral angles above this are sharp edges [rad].
constexpr double sharp = 0.5235987755982988;
/// Facets that turn less are flat [rad].
constexpr double flat_turn = 1e-6;

/// An edge of a surface and the corners opposite to it.
struct Hinge {
  mesh::Segment ends{};
  Index left = no_index, right = no_index;
};

std::vector<Hinge> hinges_of(const std::vector<mesh::Triangle>& triangles) {
  std::map<std::pair<Index, Index>, Hinge> hinges;
  for (const mesh::Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = t[k], b = t[(k + 1) % 3], opposite = t[(k + 2) % 3];
      auto [at, is_new] = hinges.try_emplace(std::minmax(a, b), Hinge{{a, b}, opposite, no_index});
      if (!is_new) at->second.right = opposite;
    }
  std::vector<Hinge> result;
  for (const auto& [ends, hinge] : hinges)
    if (hinge.right != no_index) result.push_back(hinge);
  return result;
}

double volume_of(const std::vector<Vec3>& x, const std::vector<mesh::Triangle>& triangles) {
  double sum = 0.0;
  for (const mesh::Triangle& t : triangles) sum += x[t[0]].dot(x[t[1]].cross(x[t[2]])) / 6.0;
  return sum;
}

/// Radius of curvature across a hinge; infinity where it is flat, or concave seen from the side that `outside` is the sign
/// of (0: from either).
double radius_of(const Hinge& h, const std::vector<Vec3>& x, double outside) {
  const Vec3 &a = x[h.ends[0]], edge = x[h.ends[1]] - a;
  const Vec3 left = edge.cross(x[h.left] - a), right = (x[h.right] - a).cross(edge);
  const double angle = std::atan2(left.cross(right).norm(), left.dot(right));
  const bool concave = outside * left.dot(x[h.right] - a) > 0.0;
  if (!(angle > flat_turn) || concave) return std::numeric_limits<double>::infinity();
  return angle > sharp ? 0.0 : 0.5 * (left.norm() + right.norm()) / edge.norm() / angle;
}

/// Vertices by cells of a grid.
class Cells {
 public:
  Cells(const std::vector<Vec3>& places, double width) : places_(places), width_(width) {
    for (Index v = 0; v < static_cast<Index>(places.size()); ++v) cells_[key(cell(places[v]))].push_back(v);
  }
  /// Calls f(vertex) at least for those within a box.
  template <class F>
  void visit(const Vec3& low, const Vec3& high, const F& f) const {
    const Cell a = cell(low), b = cell(high);
    double count = 1.0;
    for (std::size_t k = 0; k < 3; ++k) count *= static_cast<double>(b[k] - a[k] + 1);
    if (count > static_cast<double>(cells_.size())) {
      for (Index v = 0; v < static_cast<Index>(places_.size()); ++v) f(v);
      return;
    }
    for (long i = a[0]; i <= b[0]; ++i)
      for (long j = a[1]; j <= b[1]; ++j)
        for (long k = a[2]; k <= b[2]; ++k)
          if (const auto at = cells_.find(key({i, j, k})); at != cells_.end())
            for (const Index v : at->second) f(v);
  }

 private:
  using Cell = std::array<long, 3>;
  [[nodiscard]] Cell cell(const Vec3& x) const {
    Cell c{};
    for (int k = 0; k < 3; ++k)
      c[static_cast<std::size_t>(k)] = static_cast<long>(std::floor(std::clamp(x[k] / width_, -1e5, 1e5)));
    return c;
  }
  /// Cells beyond a million from the origin share keys, which costs time only.
  [[nodiscard]] static std::size_t key(const Cell& c) {
    constexpr std::size_t mask = (std::size_t{1} << 21) - 1;
    std::size_t value = 0;
    for (const long i : c) value = value << 21 | (static_cast<std::size_t>(i) & mask);
    return value;
  }
  const std::vector<Vec3>& places_;
  double width_;
  std::unordered_map<std::size_t, std::vector<Index>> cells_;
};

/// Of a point from the segment of a bend.
double distance(const Vec3& x, const Bend& b) {
  const Vec3 along = b.to - b.from;
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((x - b.from).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (x - b.from - t * along).norm();
}

double size_at(double radius, const adapt::SizeOptions& o, double apart) {
  return std::max(o.smallest, o.angle * (radius + apart));
}

}  // namespace

std::vector<Bend> bends_of(const std::vector<Vec3>& points, const std::vector<mesh::Triangle>& triangles,
                           const adapt::SizeOptions& o, double apart) {
  const double volume = geometry::is_closed(triangles) ? volume_of(points, triangles) : 0.0;
  const double outside = volume > 0.0 ? 1.0 : volume < 0.0 ? -1.0 : 0.0;
  std::vector<Bend> bends;
  for (const Hinge& h : hinges_of(triangles)) {
    const double size = size_at(radius_of(h, points, outside), o, apart);
    if (size < o.largest) bends.push_back({points[h.ends[0]], points[h.ends[1]], 0.0, size});
  }
  return bends;
}

std::vector<Bend> bends_of(const system::ContactScene& scene, const adapt::SizeOptions& o, double ahead) {
  using Shape = contact::Obstacle::Shape;
  const double now = scene.time(), apart = scene.input().options.distance;
  std::vector<Vec3> later = scene.points().now;
  std::vector<contact::Plane> planes = scene.set().planes();
  scene.place_obstacles(now + ahead, later, planes);
  std::vector<Bend> bends;
  for (std::size_t k = 0; k < scene.obstacles().size(); ++k) {
    const contact::Obstacle& obstacle = scene.obstacles()[k];
    if (obstacle.shape == Shape::plane) continue;
    const std::vector<Vec3> places = system::obstacle_points(scene, k), then = scene.obstacles().points(k, later);
    std::vector<Bend> own;
    const double skin = 0.5 * obstacle.thickness;
    if (obstacle.shape == Shape::mesh) {
      own = bends_of(places, obstacle.triangles, o, apart + skin);
    } else {
      const double size = size_at(obstacle.radius, o, apart + skin);
      if (size < o.largest) own.push_back({places.front(), places.back(), obstacle.radius + skin, size});
    }
    double advance = 0.0;
    for (std::size_t i = 0; i < places.size(); ++i) advance = std::max(advance, (then[i] - places[i]).norm());
    for (Bend& b : own) b.advance = advance;
    bends.insert(bends.end(), own.begin(), own.end());
  }
  return bends;
}

void bound_near(const std::vector<Bend>& bends, const std::vector<Vec3>& places, const std::vector<double>& advance,
                double largest, std::vector<double>& bound) {
  if (bends.empty() || places.empty()) return;
  const Cells cells(places, largest);
  const double fastest = advance.empty() ? 0.0 : *std::max_element(advance.begin(), advance.end());
  for (const Bend& b : bends) {
    const double reach = largest - b.size + b.radius + b.advance + fastest;
    const Vec3 low = b.from.cwiseMin(b.to).array() - reach, high = b.from.cwiseMax(b.to).array() + reach;
    cells.visit(low, high, [&](Index v) {
      const double nearer = b.advance + (advance.empty() ? 0.0 : advance[v]);
      const double gap = distance(places[v], b) - b.radius - nearer;
      bound[v] = std::min(bound[v], b.size + std::max(gap, 0.0));
    });
  }
}

}  // namespace voile::setup

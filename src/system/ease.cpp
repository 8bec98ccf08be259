#include "ease.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/mpi.hpp"
#include "geometry/closest_triangle.hpp"

namespace voile::system {

namespace {

using contact::Obstacle;

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double length = (b - a).squaredNorm();
  const double along = length > 0.0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0.0;
  return (p - a - along * (b - a)).norm();
}

/// Lowers the ease of some vertices to their distance from one obstacle, whose points are where they are now.
void lower_to(const Obstacle& o, const std::vector<Vec3>& points, const std::vector<Vec3>& x, std::size_t begin,
              std::vector<double>& ease) {
  const auto lower = [&](std::size_t v, double distance) {
    ease[v] = std::min(ease[v], std::abs(distance - 0.5 * o.thickness));
  };
  const std::size_t end = ease.size();
  if (o.shape == Obstacle::Shape::mesh) {
    const geometry::ClosestTriangle tree(points, o.triangles);
    for (std::size_t v = begin; v < end; ++v) {
      const mesh::Triangle& t = o.triangles[tree.find(x[v])];
      const std::array<Vec3, 3> corners{points[t[0]], points[t[1]], points[t[2]]};
      const Vec3 w = geometry::nearest_weights(x[v], corners);
      lower(v, (x[v] - w[0] * corners[0] - w[1] * corners[1] - w[2] * corners[2]).norm());
    }
    return;
  }
  for (std::size_t v = begin; v < end; ++v)
    lower(v, distance_to_segment(x[v], points.front(), points.back()) - o.radius);
}

}  // namespace

bool has_bodies(const ContactInput& input) {
  return std::any_of(input.obstacles.begin(), input.obstacles.end(),
                     [](const Obstacle& o) { return o.shape != Obstacle::Shape::plane; });
}

std::vector<double> ease(const ContactScene& scene, Vec a) {
  const MPI_Comm comm = scene.dofs().comm();
  const auto count = static_cast<std::size_t>(scene.dofs().mesh().vertex_count());
  const auto rank = static_cast<std::size_t>(mpi::rank(comm)), ranks = static_cast<std::size_t>(mpi::size(comm));
  const std::size_t begin = count * rank / ranks, end = count * (rank + 1) / ranks;
  const std::vector<Vec3> x = scene.positions(a);
  std::vector<double> own(end, std::numeric_limits<double>::infinity());
  mpi::on_all(comm, [&] {
    const std::vector<Obstacle>& all = scene.input().obstacles;
    for (std::size_t k = 0; k < all.size(); ++k)
      if (all[k].shape != Obstacle::Shape::plane) lower_to(all[k], obstacle_points(scene, k), x, begin, own);
  });
  std::fill_n(own.begin(), begin, 0.0);
  own.resize(count, 0.0);
  mpi::sum_to_root(comm, own);
  if (rank != 0) own.clear();
  return own;
}

EaseRange range_of_ease(const ContactScene& scene, const std::vector<double>& ease,
                        const std::vector<Index>& vertices) {
  const std::vector<double>& area = scene.set().surface().area;
  EaseRange range{std::numeric_limits<double>::infinity(), 0.0};
  double whole = 0.0;
  const auto add = [&](std::size_t v) {
    range.least = std::min(range.least, ease[v]);
    range.mean += area[v] * ease[v];
    whole += area[v];
  };
  for (const Index v : vertices) add(static_cast<std::size_t>(v));
  for (std::size_t v = 0; vertices.empty() && v < ease.size(); ++v) add(v);
  range.mean /= whole;
  return range;
}

}  // namespace voile::system

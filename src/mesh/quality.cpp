#include "quality.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace voile::mesh {

namespace {

/// How far the neighbour across side s is from completing a parallelogram with t [m]; 0 where there is none.
double offset_of_neighbour(const SurfaceMesh& mesh, Index t, int s) {
  const Index n = mesh.neighbour(t, s);
  if (n == no_index) return 0.0;
  const int sn = mesh.side_in_neighbour(t, s);
  const Vec3 corner = mesh.rest_corner(t, s), a = mesh.rest_corner(t, (s + 1) % 3),
             b = mesh.rest_corner(t, (s + 2) % 3);
  const Vec3 along = (b - a).normalized();
  const Vec3 across = a + (corner - a).dot(along) * along - corner;  // from the corner to the side
  const double length = (b - a).norm(), height = across.norm();
  // The corner lies at (foot, height) above the side, the apex is wanted at (length - foot, -height).
  const Vec2 wanted(length - (corner - a).dot(along), -height);
  // In the neighbour's own chart, where the side runs the other way.
  const Vec3 start = mesh.rest_corner(n, (sn + 2) % 3), x = mesh.rest_corner(n, sn) - start;
  const Vec3 side = (mesh.rest_corner(n, (sn + 1) % 3) - start).normalized();
  const double foot = x.dot(side);
  return (Vec2(foot, -(x - foot * side).norm()) - wanted).norm();
}

}  // namespace

TriangleShape shape_of(const SurfaceMesh& mesh, Index t) {
  TriangleShape shape;
  shape.smallest_angle = std::numbers::pi;
  double longest = 0.0, offset = 0.0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 corner = mesh.rest_corner(t, i);
    const Vec3 a = mesh.rest_corner(t, (i + 1) % 3) - corner, b = mesh.rest_corner(t, (i + 2) % 3) - corner;
    // The arc tangent keeps its digits for the smallest angles, where the arc cosine loses half of them.
    shape.smallest_angle = std::min(shape.smallest_angle, std::atan2(a.cross(b).norm(), a.dot(b)));
    longest = std::max(longest, a.norm());
    offset = std::max(offset, offset_of_neighbour(mesh, t, i));
  }
  shape.aspect = longest * longest / (2.0 * mesh.area(t));
  shape.unevenness = offset / longest;
  return shape;
}

Vec3 centroid(const SurfaceMesh& mesh, Index t) {
  return (mesh.start_corner(t, 0) + mesh.start_corner(t, 1) + mesh.start_corner(t, 2)) / 3.0;
}

}  // namespace voile::mesh

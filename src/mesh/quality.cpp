#include "voile/mesh/quality.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace voile::mesh {

namespace {

/// How far the neighbour across side s is from completing a parallelogram with t [m]; 0 where there is none.
double offset_of_neighbour(const SurfaceMesh& mesh, Index t, int s) {
  const Index apex = mesh.apex(t, s);
  if (apex == no_index) return 0.0;
  const Vec3 corner = mesh.corner(t, s), a = mesh.corner(t, (s + 1) % 3), b = mesh.corner(t, (s + 2) % 3);
  const Vec3 along = (b - a).normalized();
  const Vec3 across = a + (corner - a).dot(along) * along - corner;  // from the corner to the side
  const double length = (b - a).norm(), height = across.norm();
  // The corner lies at (foot, height) above the side, the apex is wanted at (length - foot, -height).
  const Vec2 wanted(length - (corner - a).dot(along), -height);
  const Vec3 x = mesh.positions()[static_cast<std::size_t>(apex)] - a;
  const double foot = x.dot(along);
  return (Vec2(foot, -(x - foot * along).norm()) - wanted).norm();
}

}  // namespace

TriangleShape shape_of(const SurfaceMesh& mesh, Index t) {
  TriangleShape shape;
  shape.smallest_angle = std::numbers::pi;
  double longest = 0.0, offset = 0.0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 a = mesh.corner(t, (i + 1) % 3) - mesh.corner(t, i), b = mesh.corner(t, (i + 2) % 3) - mesh.corner(t, i);
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
  return (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
}

}  // namespace voile::mesh

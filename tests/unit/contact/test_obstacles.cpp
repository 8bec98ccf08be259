// Obstacles among the points of a surface: where they are, and what is free of them.
#include <doctest/doctest.h>

#include <algorithm>

#include "contact/obstacles.hpp"
#include "contact/surface.hpp"
#include "test_meshes.hpp"

namespace test_obstacles {

using namespace voile;
using namespace voile::contact;
using namespace voile::testing;

namespace {

/// A cube of side 1 from this corner on, its triangles turned outwards.
Obstacle cube(const Vec3& corner) {
  Obstacle o;
  for (int i = 0; i < 8; ++i) o.points.push_back(corner + Vec3(i & 1, i >> 1 & 1, i >> 2));
  o.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return o;
}

Obstacle shaped(Obstacle::Shape shape, std::vector<Vec3> points) {
  Obstacle o;
  o.shape = shape;
  o.points = std::move(points);
  return o;
}

/// A small triangle of a sheet, level, with its first corner here.
std::array<Vec3, 3> level(const Vec3& at) {
  return {at, at + Vec3(0.1, 0.0, 0.0), at + Vec3(0.0, 0.1, 0.0)};
}

struct Scene {
  Surface surface;
  Obstacles obstacles;
  std::vector<Vec3> x;
  std::vector<Plane> planes;

  explicit Scene(const std::vector<Obstacle>& list)
      : surface(make_surface(mesh::SurfaceMesh(grid(2, 2, false, 0.0)),
                             std::vector<Body>(list.size() + 1, {"some", 0.0}), {})),
        obstacles(list, 1, surface),
        x(surface.rest),
        planes(obstacles.planes()) {
    obstacles.place(0.0, x, planes);
  }
  [[nodiscard]] bool is_free(std::size_t k, const std::array<Vec3, 3>& corners, double apart) const {
    return obstacles.is_free(k, corners, x, planes, apart);
  }
};

}  // namespace

TEST_CASE("a triangle is free of an obstacle that it is apart from, and not inside") {
  using Shape = Obstacle::Shape;
  const Scene s({cube(Vec3::Zero()), cube(Vec3(10.0, 0.0, 0.0)), shaped(Shape::sphere, {Vec3(20.0, 0.0, 0.0)}),
                 shaped(Shape::plane, {Vec3(0.0, 0.0, -1.0)}),
                 shaped(Shape::capsule, {Vec3(30.0, 0.0, 0.0), Vec3(30.0, 1.0, 0.0)})});
  for (std::size_t k : {0, 1}) {
    const Vec3 corner(10.0 * static_cast<double>(k), 0.0, 0.0);
    CHECK(s.is_free(k, level(corner + Vec3(0.3, 0.3, 1.2)), 0.19));
    CHECK(!s.is_free(k, level(corner + Vec3(0.3, 0.3, 1.2)), 0.21));
    CHECK(!s.is_free(k, level(corner + Vec3(0.4, 0.4, 0.5)), 0.1));    // inside
    CHECK(!s.is_free(k, level(corner + Vec3(0.95, 0.4, 0.5)), 0.01));  // through a face
    CHECK(s.is_free(1 - k, level(corner + Vec3(0.4, 0.4, 0.5)), 0.1));
  }
  CHECK(s.is_free(2, level(Vec3(20.0, 0.0, 0.3)), 0.29));
  CHECK(!s.is_free(2, level(Vec3(20.0, 0.0, 0.3)), 0.31));
  CHECK(s.is_free(3, level(Vec3(5.0, 5.0, -0.8)), 0.19));
  CHECK(!s.is_free(3, level(Vec3(5.0, 5.0, -0.8)), 0.21));
  CHECK(s.is_free(4, level(Vec3(30.0, 0.5, 0.2)), 0.19));
  CHECK(!s.is_free(4, level(Vec3(30.0, 0.5, 0.2)), 0.21));
}

TEST_CASE("points of an obstacle are those among all points; a rigid motion takes a material point along") {
  Obstacle rising = cube(Vec3(0.0, 2.0, 0.0));
  rising.motion = [](const Vec3&, double t) { return Vec3(0.0, 0.0, 2.0 * t); };
  Scene s({cube(Vec3::Zero()), rising});
  s.obstacles.place(0.5, s.x, s.planes);
  const std::vector<Vec3> at = s.obstacles.points(1, s.x);
  REQUIRE(at.size() == 8);
  CHECK(at[0] == Vec3(0.0, 2.0, 1.0));
  CHECK(s.obstacles.points(0, s.x)[7] == Vec3(1.0, 1.0, 1.0));
  CHECK(s.obstacles.displacement(2, at[0], 0.5, 0.75)->isApprox(Vec3(0.0, 0.0, 0.5)));
  CHECK(*s.obstacles.displacement(1, at[0], 0.5, 0.75) == Vec3::Zero());
  CHECK(!s.obstacles.of_body(0));
  CHECK(!s.obstacles.of_body(3));
  CHECK(s.obstacles.of_body(2) == 1);
}

}  // namespace test_obstacles

// Untangling of starts: shallow intersections of every kind go, deep ones stay, what is fixed does not move.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/decompositions.hpp"
#include "formats/triangle_file.hpp"
#include "geometry/intersections.hpp"
#include "geometry/winding.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"
#include "untangle/untangle.hpp"
#include "voile/errors.hpp"

namespace test_untangle {

using namespace voile;
using namespace voile::testing;

namespace {

constexpr double d = 2e-3;

/// Sheets of side 1, each bent by its own map.
mesh::MeshData sheets(int cells, const std::vector<std::function<Vec3(const Vec3&)>>& maps) {
  mesh::MeshData all;
  all.source = "sheets";
  for (const auto& map : maps) {
    const mesh::MeshData one = grid(cells, cells, all.positions.empty(), 0.1, 3u);
    const auto first = static_cast<Index>(all.positions.size());
    for (const Vec3& x : one.positions) all.positions.push_back(map(x));
    for (const mesh::Triangle& t : one.triangles) all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return all;
}

/// A scene of a sheet (body 0) and obstacles.
struct Scene {
  contact::Surface surface;
  std::vector<contact::Plane> planes;
  std::vector<Mat3> free;
  std::vector<Vec3> x;

  explicit Scene(const mesh::MeshData& data, double thickness = 0.0)
      : surface(contact::make_surface(mesh::SurfaceMesh(data), {{"sheet", thickness}}, {})),
        free(static_cast<std::size_t>(surface.sheet_points), Mat3::Identity()),
        x(surface.rest) {
    surface.rules = {{contact::Rule{}}};
  }
  int add_body(double thickness) {
    surface.bodies.push_back({"obstacle", thickness});
    const std::size_t n = surface.bodies.size();
    surface.rules.assign(n, std::vector<contact::Rule>(n));
    for (std::size_t i = 1; i < n; ++i)
      for (std::size_t j = 1; j < n; ++j) surface.rules[i][j].touch = false;
    return static_cast<int>(n) - 1;
  }
  void add(const std::vector<Vec3>& points, const std::vector<mesh::Triangle>& triangles, double thickness = 0.0) {
    contact::append(surface, add_body(thickness), points, triangles, {});
    x = surface.rest;
  }
  [[nodiscard]] std::vector<geometry::TrianglePair> find(const std::vector<Vec3>& at) const {
    std::vector<mesh::Triangle> triangles;
    std::vector<Index> body;
    for (const contact::Face& f : surface.faces) {
      triangles.push_back(f.points);
      body.push_back(f.body);
    }
    return geometry::intersecting_triangles(at, triangles, body,
                                            [&](Index a, Index b) { return !surface.rules[a][b].touch; });
  }
  untangle::UntangleResult untangle(double limit, int rounds = 100) {
    const untangle::UntangleResult r = untangle::untangle(
        surface, planes, free, [&](const std::vector<Vec3>& at) { return find(at); },
        {.activation_distance = d, .limit = limit, .rounds = rounds}, x);
    CAPTURE(r.rounds);
    CAPTURE(r.left);
    CAPTURE(r.gap);
    CHECK(find(x).size() == r.left);
    if (r.done) CHECK(r.gap > 0.0);
    return r;
  }
};

/// A cube of half the side h around c, turned onto a corner if asked for.
geometry::TriangleSoup cube(const Vec3& c, double h, bool on_corner) {
  geometry::TriangleSoup s;
  const Mat3 turn = on_corner ? rotation_between(Vec3(1, 1, 1), Vec3(0.02, 0.01, 1)) : Mat3(Mat3::Identity());
  for (int i = 0; i < 8; ++i)
    s.positions.push_back(c + h * (turn * Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  s.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return s;
}

Vec3 same(const Vec3& x) {
  return x;
}

}  // namespace

TEST_CASE("winding number: 1 inside, 0 outside, a half in the plane of an open face") {
  const geometry::TriangleSoup s = cube(Vec3(1, 2, 3), 0.5, true);
  CHECK(geometry::winding_number(Vec3(1.1, 2.2, 3.1), s.positions, s.triangles) == relative(1.0));
  CHECK(std::abs(geometry::winding_number(Vec3(1.1, 2.2, 4.1), s.positions, s.triangles)) < 1e-12);
}

TEST_CASE("untangle: a bulge of one sheet through another") {
  const auto bulge = [](const Vec3& x) {
    const double r2 = (x - Vec3(0.52, 0.47, 0)).squaredNorm();
    return Vec3(x[0] + 0.013, x[1] - 0.017, -0.02 + 0.05 * std::exp(-r2 / 0.02));
  };
  for (const double thickness : {0.0, 4e-3}) {
    Scene scene(sheets(20, {same, bulge}), thickness);
    CHECK(scene.find(scene.x).size() > 20);
    CHECK(scene.untangle(0.25).done);
  }
}

TEST_CASE("untangle: a border that dips through another sheet, by one cell and by two") {
  for (const double width : {0.03, 0.08}) {
    const auto tilt = [&](const Vec3& x) { return Vec3(0.9 * x[0] + 0.05, 0.9 * x[1] + 0.03, 0.3 * (x[0] - width)); };
    Scene scene(sheets(20, {same, tilt}));
    CHECK(scene.find(scene.x).size() > 20);
    CHECK(scene.untangle(0.25).done);
  }
}

TEST_CASE("untangle: waves of three sheets through each other, borders not quite above each other") {
  const auto wave = [](double height, double k, double shift) {
    return [=](const Vec3& x) {
      return Vec3(x[0] + shift, x[1] - 0.5 * shift,
                  height + 0.012 * (std::sin(k * x[0] + 5.0 * x[1]) + std::cos(7.0 * x[0] - k * x[1])));
    };
  };
  Scene scene(sheets(24, {wave(0.0, 4.0, 0.0), wave(0.02, 7.0, 0.012), wave(0.04, 5.5, -0.009)}));
  CHECK(scene.find(scene.x).size() > 100);
  CHECK(scene.untangle(0.2).done);
}

TEST_CASE("untangle: sheets that cross in their middle are not shallow") {
  const auto upright = [](const Vec3& x) { return Vec3(0.5 + 0.013 * x[0], x[1], x[0] - 0.49); };
  Scene scene(sheets(12, {same, upright}));
  const untangle::UntangleResult r = scene.untangle(0.2);
  CHECK(!r.done);
  CHECK(r.left > 0);
}

TEST_CASE("untangle: out of a ball, a half-space and closed meshes") {
  SUBCASE("ball") {
    Scene scene(sheets(20, {same}));
    scene.add({Vec3(0.5, 0.5, -0.26)}, {}, 0.6);
    const untangle::UntangleResult r = scene.untangle(0.25);
    CHECK(r.done);
    CHECK(r.farthest < 0.08);
    for (Index v = 0; v < scene.surface.sheet_points; ++v) CHECK((scene.x[v] - Vec3(0.5, 0.5, -0.26)).norm() > 0.3);
  }
  SUBCASE("half-space") {
    Scene scene(sheets(10, {[](const Vec3& x) { return Vec3(x[0], x[1], 0.1 * std::sin(9.0 * x[0] * x[1])); }}));
    scene.planes.push_back({scene.add_body(0.0), Vec3::UnitZ(), -0.05});
    CHECK(scene.untangle(0.25).done);
    for (const Vec3& p : scene.x) CHECK(p[2] > -0.05);
  }
  SUBCASE("cube face") {
    Scene scene(sheets(20, {same}));
    const geometry::TriangleSoup s = cube(Vec3(0.51, 0.48, -0.23), 0.25, false);
    scene.add(s.positions, s.triangles);
    const untangle::UntangleResult r = scene.untangle(0.25);
    CHECK(r.done);
    CHECK(r.farthest < 0.06);
  }
  SUBCASE("corner of a cube in the middle of a triangle") {
    Scene scene(sheets(5, {same}));
    const geometry::TriangleSoup s = cube(Vec3(0.53, 0.46, 0.02 - 0.1 * std::sqrt(3.0)), 0.1, true);
    scene.add(s.positions, s.triangles);
    CHECK(!scene.find(scene.x).empty());
    CHECK(scene.untangle(0.5).done);
  }
  SUBCASE("sphere mesh") {
    Scene scene(sheets(20, {same}));
    const geometry::TriangleSoup s = geometry::sphere_surface(Vec3(0.5, 0.5, -0.26), 0.3, 3);
    scene.add(s.positions, s.triangles, 2e-3);
    CHECK(scene.untangle(0.25).done);
  }
  SUBCASE("cylinder mesh across the sheet") {
    Scene scene(sheets(20, {same}));
    const geometry::TriangleSoup s =
        geometry::cylinder_surface(Vec3(0.3, 0.45, -0.17), Vec3(0.7, 0.55, -0.17), 0.2, 1e-3);
    scene.add(s.positions, s.triangles);
    CHECK(scene.untangle(0.25).done);
  }
  SUBCASE("a sheet wholly inside a closed mesh stays, and one that pokes out goes back") {
    for (const double height : {0.2, 0.49}) {  // the lid is at 0.46
      Scene scene(sheets(10, {[&](const Vec3& x) {
                           return Vec3(0.8 * x[0], 0.8 * x[1],
                                       height * std::exp(-20.0 * (x - Vec3(0.5, 0.5, 0)).squaredNorm()));
                         }}));
      const geometry::TriangleSoup s = cube(Vec3(0.4, 0.4, -0.04), 0.5, false);
      scene.add(s.positions, s.triangles);
      const untangle::UntangleResult r = scene.untangle(0.2);
      CHECK(r.done);
      CHECK((r.moved == 0) == (height < 0.4));
    }
  }
}

TEST_CASE("untangle: what lies exactly in one another is parted by half the distance each") {
  Scene scene(sheets(8, {same, same}));
  const std::vector<Vec3> start = scene.x;
  CHECK(scene.find(scene.x).size() > 50);
  const untangle::UntangleResult r = scene.untangle(0.25);
  CHECK(r.done);
  CHECK(r.gap >= d);
  CHECK(r.farthest < 0.6 * d);
  CHECK(r.rounds < 5);
}

TEST_CASE("untangle: gaps below the activation distance are widened where nothing intersects") {
  for (const double gap : {0.95, 0.92, 0.5}) {
    CAPTURE(gap);
    const auto above = [&](const Vec3& x) { return Vec3(x[0] + 0.013, x[1] - 0.017, gap * d); };
    Scene scene(sheets(8, {same, above}));
    const untangle::UntangleResult r = scene.untangle(0.25);
    CHECK(r.done);
    CHECK(r.gap >= d);
    CHECK(r.farthest < (1.1 - gap) * d);
  }
}

TEST_CASE("untangle: what is fixed does not move, and what may only slide slides") {
  const Vec3 centre(0.5, 0.5, -0.26);
  Scene scene(sheets(20, {same}));
  scene.add({centre}, {}, 0.54);
  for (Mat3& p : scene.free) p.setZero();
  const std::vector<Vec3> before = scene.x;
  const untangle::UntangleResult r = scene.untangle(0.25, 10);
  CHECK(!r.done);
  CHECK(r.moved == 0);
  CHECK(scene.x == before);
  for (Mat3& p : scene.free) p = Vec3(0, 0, 1).asDiagonal();
  CHECK(scene.untangle(0.25).done);
  for (std::size_t v = 0; v < before.size(); ++v) CHECK((scene.x[v] - before[v]).head<2>().norm() < 1e-15);
  scene.free.pop_back();
  CHECK_THROWS_AS((void)scene.untangle(0.25), InternalError);
}

}  // namespace test_untangle

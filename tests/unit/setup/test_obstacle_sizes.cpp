// What obstacles ask of the sizes beside them: curvature of meshes, sharp and concave edges, distances.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "../test_relative.hpp"
#include "extent.hpp"
#include "setup/obstacle_sizes.hpp"

namespace test_obstacle_sizes {

using namespace voile;
using setup::Bend;

namespace {

constexpr double pi = std::numbers::pi, angle = 0.25, apart = 1e-3;

adapt::SizeOptions options(double smallest, double largest) {
  adapt::SizeOptions o;
  o.angle = angle;
  o.smallest = smallest;
  o.largest = largest;
  return o;
}

/// A tube about z, open at its ends; normals point outwards.
void tube(double radius, int around, std::vector<Vec3>& points, std::vector<mesh::Triangle>& triangles) {
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < around; ++i)
      points.emplace_back(radius * std::cos(2 * pi * i / around), radius * std::sin(2 * pi * i / around), 0.05 * j);
  for (int i = 0; i < around; ++i) {
    const Index a = i, b = (i + 1) % around;
    triangles.push_back({a, b, b + around});
    triangles.push_back({a, b + around, a + around});
  }
}

/// A closed prism of unit height over an L, whose inner corner is concave at (1, 1).
void prism(std::vector<Vec3>& points, std::vector<mesh::Triangle>& triangles) {
  const std::vector<Vec2> outline{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (const double z : {0.0, 1.0})
    for (const Vec2& p : outline) points.emplace_back(p[0], p[1], z);
  for (Index i = 0; i < 6; ++i) {
    const Index j = (i + 1) % 6;
    triangles.push_back({i, j, j + 6});
    triangles.push_back({i, j + 6, i + 6});
  }
  for (const mesh::Triangle& t : {mesh::Triangle{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    triangles.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
    triangles.push_back({t[0], t[2], t[1]});
  }
}

bool is_at(const Bend& b, const Vec2& corner) {
  return (b.from.head<2>() - corner).norm() < 1e-12 && (b.to.head<2>() - corner).norm() < 1e-12;
}

}  // namespace

TEST_CASE("a faceted tube asks for edges of its radius times the angle, and a wide one for nothing") {
  std::vector<Vec3> points;
  std::vector<mesh::Triangle> triangles;
  tube(0.04, 40, points, triangles);
  const std::vector<Bend> bends = setup::bends_of(points, triangles, options(1e-3, 0.05), apart);
  CHECK(bends.size() == 40);  // the edges along it; the diagonals are flat
  for (const Bend& b : bends) CHECK(b.size == relative(angle * (0.04 + apart)).epsilon(0.01));
  CHECK(setup::bends_of(points, triangles, options(1e-3, 0.01), apart).empty());
}

TEST_CASE(
    "sharp convex edges ask for the smallest edges, concave and flat ones for nothing, whatever way a body turns") {
  std::vector<Vec3> points;
  std::vector<mesh::Triangle> triangles;
  prism(points, triangles);
  const adapt::SizeOptions o = options(0.01, 0.3);
  for (const bool inside_out : {false, true}) {
    CAPTURE(inside_out);
    if (inside_out)
      for (mesh::Triangle& t : triangles) std::swap(t[1], t[2]);
    int concave = 0, convex = 0;
    const std::vector<Bend> bends = setup::bends_of(points, triangles, o, apart);
    for (const Bend& b : bends) {
      CHECK(b.size == 0.01);
      concave += is_at(b, {1, 1});
      for (const Vec2& corner : {Vec2(0, 0), Vec2(2, 0), Vec2(2, 1), Vec2(1, 2), Vec2(0, 2)})
        convex += is_at(b, corner);
    }
    CHECK(concave == 0);
    CHECK(convex == 5);
    CHECK(bends.size() == 17);  // and the rims at the top and at the bottom
  }
  triangles.pop_back();  // open: the sheet may be on either side
  CHECK(setup::bends_of(points, triangles, o, apart).size() > 15);
  int concave = 0;
  for (const Bend& b : setup::bends_of(points, triangles, o, apart)) concave += is_at(b, {1, 1});
  CHECK(concave == 1);
}

TEST_CASE("bounds grow with the distance from a bend, less what comes nearer, as a search of all pairs finds them") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.3, 0.3);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  constexpr double largest = 0.05;
  std::vector<Bend> bends;
  for (int k = 0; k < 20; ++k) {
    const Vec3 from = point();
    bends.push_back(
        {from, k % 3 == 0 ? from : Vec3(from + 0.3 * point()), 0.01 * (k % 4), 0.002 * (k % 5 + 1), 0.005 * (k % 2)});
  }
  std::vector<Vec3> places;
  std::vector<double> advance;
  for (int v = 0; v < extent(300, 60); ++v) {
    places.push_back(point());
    advance.push_back(0.001 * (v % 7));
  }
  std::vector<double> bound(places.size(), std::numeric_limits<double>::infinity());
  setup::bound_near(bends, places, advance, largest, bound);
  int near = 0;
  for (std::size_t v = 0; v < places.size(); ++v) {
    double expected = std::numeric_limits<double>::infinity();
    for (const Bend& b : bends) {
      double distance = 1.0;
      constexpr int samples = 2000;
      for (int i = 0; i <= samples; ++i)
        distance = std::min(distance, (places[v] - b.from - i * (b.to - b.from) / samples).norm());
      expected = std::min(expected, b.size + std::max(0.0, distance - b.radius - b.advance - advance[v]));
    }
    if (expected >= largest) {
      CHECK(bound[v] >= largest - 1e-6);
      continue;
    }
    ++near;
    CHECK(std::abs(bound[v] - expected) < 1e-6);
  }
  CHECK(near > extent(30, 6));
}

}  // namespace test_obstacle_sizes

// Welding keeps mass and momentum, and every triangle its rest shape.
#include <doctest/doctest.h>

#include <random>

#include "mesh/weld.hpp"
#include "voile/errors.hpp"

namespace test_weld {

using namespace voile;

namespace {

/// Two squares of two triangles, a little apart, whose facing sides are a seam.
mesh::MeshData two_squares() {
  mesh::MeshData m;
  m.source = "test";
  for (const double x : {0.0, 1.1})
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)})
      m.positions.push_back(p + Vec3(x, 0, 0));
  m.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  for (const mesh::Triangle& t : m.triangles)
    m.rest.push_back({m.positions[t[0]], m.positions[t[1]], m.positions[t[2]]});
  m.groups = {{"right", 1, {1, 2}, {{1, 2}}, {}}, {"left", 1, {4, 7}, {{7, 4}}, {}}};
  m.seams = {{"side", {{1, 4}, {2, 7}}, {0.5, 0.5}}};
  return m;
}

}  // namespace

TEST_CASE("a weld keeps mass, its centre and momentum to round-off") {
  const mesh::MeshData m = two_squares();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.1, 1.0);
  std::vector<double> mass, velocity;
  for (std::size_t v = 0; v < 8; ++v) {
    mass.push_back(uniform(random));
    for (int k = 0; k < 3; ++k) velocity.push_back(uniform(random));
  }
  const mesh::Welded w = mesh::weld(m, {"side"}, m.positions, mass);
  REQUIRE(w.data.positions.size() == 6);
  std::vector<double> new_mass(6, 0.0);
  for (std::size_t v = 0; v < 8; ++v) new_mass[w.target[v]] += mass[v];
  const std::vector<double> after = mesh::merged_means(w.target, mass, velocity, 3);
  Vec3 p = Vec3::Zero(), q = Vec3::Zero(), c = Vec3::Zero(), d = Vec3::Zero();
  for (std::size_t v = 0; v < 8; ++v) p += mass[v] * Eigen::Map<Vec3>(&velocity[3 * v]), c += mass[v] * m.positions[v];
  for (std::size_t v = 0; v < 6; ++v)
    q += new_mass[v] * Eigen::Map<const Vec3>(&after[3 * v]), d += new_mass[v] * w.data.positions[v];
  CHECK((p - q).norm() < 1e-12 * p.norm());
  CHECK((c - d).norm() < 1e-12 * c.norm());
  CHECK(after[0] == velocity[0]);  // what is not sewn stays to the last digit
}

TEST_CASE("the welded mesh: charts, groups, other seams") {
  mesh::MeshData m = two_squares();
  m.seams.push_back({"other", {{0, 5}}, {1.0}});
  CHECK(mesh::open_seams(m, {"all"}).size() == 2);
  CHECK(mesh::open_seams(m, {"side", "gone"}) == std::vector<std::string>{"side"});
  const std::vector<double> mass(8, 1.0);
  const mesh::Welded w = mesh::weld(m, {"side"}, m.positions, mass);
  CHECK(w.data.rest == m.rest);
  REQUIRE(w.data.seams.size() == 1);
  CHECK(w.data.seams[0].pairs[0] == std::array<Index, 2>{w.target[0], w.target[5]});
  const mesh::SurfaceMesh surface(w.data);
  CHECK(surface.component_count() == 1);
  CHECK(surface.group("left").vertices == surface.group("right").vertices);
  const mesh::SeamGap gap = mesh::widest_gap(m, {"side"}, m.positions);
  CHECK(gap.seam == "side");
  CHECK(gap.gap == doctest::Approx(0.1));
  const std::vector<Index> joined = mesh::joined_vertices(m);
  CHECK(joined[1] == joined[4]);
  CHECK(joined[0] == joined[5]);
  CHECK(joined[3] != joined[6]);
  m.seams = {{"fold", {{0, 1}}, {1.0}}};
  CHECK_THROWS_AS((void)mesh::weld(m, {"fold"}, m.positions, mass), UserError);
}

TEST_CASE("lengths of the sides of an open seam are those at rest, a dart's with its tip") {
  mesh::MeshData m = two_squares();
  for (Vec3& corner : m.rest[2]) corner *= 2.5;
  for (Vec3& corner : m.rest[3]) corner *= 2.5;
  CHECK(mesh::side_lengths(mesh::SurfaceMesh(m), "side") == std::array{0.0, 0.0});  // without a group
  m.groups.push_back({mesh::seam_group("side"), 1, {1, 2, 4, 7}, {{1, 2}, {7, 4}}, {}});
  const std::array<double, 2> sides = mesh::side_lengths(mesh::SurfaceMesh(m), "side");
  CHECK(sides[0] == doctest::Approx(1.0));
  CHECK(sides[1] == doctest::Approx(2.5));
  CHECK(mesh::side_lengths(mesh::SurfaceMesh(m), "gone") == std::array{0.0, 0.0});

  mesh::MeshData dart;
  dart.source = "test";
  dart.positions = {{0, 0, 0}, {3, 4, 0}, {-1, 1, 0}, {-1, -1, 0}, {6, -8, 0}};
  dart.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}};
  dart.groups = {{mesh::seam_group("dart"), 1, {0, 1, 4}, {{0, 1}, {4, 0}}, {}}};
  dart.seams = {{"dart", {{1, 4}}, {5.0}}};
  const std::array<double, 2> legs = mesh::side_lengths(mesh::SurfaceMesh(dart), "dart");
  CHECK(legs[0] == doctest::Approx(5.0));
  CHECK(legs[1] == doctest::Approx(10.0));
}

}  // namespace test_weld

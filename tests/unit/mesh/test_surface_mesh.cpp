// Connectivity, orientation and the refusal of surfaces that are none.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <limits>
#include <numbers>

#include "test_joined_meshes.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_surface_mesh {

using namespace voile;
using namespace voile::testing;

namespace {

mesh::MeshData data_of(std::vector<Vec3> positions, std::vector<mesh::Triangle> triangles) {
  mesh::MeshData d;
  d.source = "sheet.msh";
  d.positions = std::move(positions);
  d.triangles = std::move(triangles);
  return d;
}

/// What the mesh is refused for; empty if it is accepted.
std::string refusal(const mesh::MeshData& d) {
  try {
    const mesh::SurfaceMesh mesh(d);
  } catch (const UserError& e) {
    return e.what();
  }
  return {};
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The triangle with its smallest vertex first: equal for equal orientations.
mesh::Triangle canonical(mesh::Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

bool has_vertex(const mesh::Triangle& t, Index v) {
  return t[0] == v || t[1] == v || t[2] == v;
}

/// A closed strip of n quadrilaterals, with a half twist or not.
mesh::MeshData strip(int n, bool twisted) {
  mesh::MeshData d;
  d.source = "strip.msh";
  const auto at = [n](int i, int k) { return static_cast<Index>(2 * (i % n) + k); };
  for (int i = 0; i < n; ++i) {
    const double phi = 2.0 * std::numbers::pi * i / n, half = twisted ? 0.5 * phi : 0.0;
    for (const double w : {-0.3, 0.3}) {
      const double r = 1.0 + w * std::cos(half);
      d.positions.push_back({r * std::cos(phi), r * std::sin(phi), w * (twisted ? std::sin(half) : 1.0)});
    }
  }
  for (int i = 0; i < n; ++i) {
    const int cross = twisted && i == n - 1 ? 1 : 0;
    const Index a = at(i, 0), b = at(i, 1), c = at(i + 1, 1 - cross), e = at(i + 1, cross);
    d.triangles.push_back({a, e, b});
    d.triangles.push_back({b, e, c});
  }
  return d;
}

}  // namespace

TEST_CASE("adjacency and side numbers agree with a search over all pairs of triangles") {
  mesh::MeshData d = grid(5, 4, true, 0.2);
  split_some(d, 7);
  const mesh::SurfaceMesh mesh(d);
  int inner = 0, outer = 0;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      const mesh::Triangle& v = mesh.triangles()[t];
      const Index a = v[(s + 1) % 3], b = v[(s + 2) % 3];
      Index expected = no_index;
      for (Index n = 0; n < mesh.triangle_count(); ++n)
        if (n != t && has_vertex(mesh.triangles()[n], a) && has_vertex(mesh.triangles()[n], b)) expected = n;
      REQUIRE(mesh.neighbour(t, s) == expected);
      CHECK(mesh.side_of(t, a, b) == s);
      CHECK(mesh.side_of(t, b, a) == s);
      if (expected == no_index) {
        ++outer;
        CHECK(mesh.apex(t, s) == no_index);
        continue;
      }
      ++inner;
      const int sn = mesh.side_in_neighbour(t, s);
      const mesh::Triangle& w = mesh.triangles()[expected];
      CHECK(mesh.neighbour(expected, sn) == t);
      CHECK(mesh.apex(t, s) == w[sn]);
      CHECK(w[sn] != a);
      CHECK(w[sn] != b);
      // Consistent orientation: the neighbour runs along the side the other way.
      CHECK(w[(sn + 1) % 3] == b);
      CHECK(w[(sn + 2) % 3] == a);
    }
  CHECK(outer == 2 * (5 + 4));
  CHECK(inner == 3 * mesh.triangle_count() - outer);
  CHECK(mesh.side_of(0, mesh.triangles()[0][0], mesh.vertex_count() - 1) == -1);
}

TEST_CASE("the triangles around a vertex are complete and ascending") {
  const mesh::SurfaceMesh mesh(grid(4, 3, true, 0.1));
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    std::vector<Index> expected;
    for (Index t = 0; t < mesh.triangle_count(); ++t)
      if (has_vertex(mesh.triangles()[t], v)) expected.push_back(t);
    CHECK(mesh.triangles_of_vertex(v) == expected);
  }
}

TEST_CASE("a consistently oriented mesh is left alone") {
  const mesh::MeshData d = grid(4, 4, false, 0.1);
  const mesh::SurfaceMesh mesh(d);
  CHECK(mesh.reoriented_count() == 0);
  CHECK(mesh.triangles() == d.triangles);
}

TEST_CASE("turned triangles are turned back and counted") {
  const mesh::MeshData original = grid(6, 5, false, 0.1);
  mesh::MeshData d = original;
  Index turned = 0;
  for (std::size_t t = 0; t < d.triangles.size(); t += 4) {  // the first triangle too: it must not decide alone
    std::swap(d.triangles[t][0], d.triangles[t][1]);
    ++turned;
  }
  const mesh::SurfaceMesh mesh(d);
  CHECK(mesh.reoriented_count() == turned);
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    CHECK(canonical(mesh.triangles()[t]) == canonical(original.triangles[t]));
    CHECK(mesh.rest_normal(t).z() == relative(1.0));
    for (int s = 0; s < 3; ++s)
      if (mesh.neighbour(t, s) != no_index)
        CHECK(mesh.neighbour(mesh.neighbour(t, s), mesh.side_in_neighbour(t, s)) == t);
  }
}

TEST_CASE("each piece of the surface keeps the orientation of its majority") {
  mesh::MeshData d = grid(4, 4, false, 0.0);
  const mesh::MeshData other = grid(3, 3, false, 0.0);
  const auto shift = static_cast<Index>(d.positions.size());
  const auto first = d.triangles.size();
  for (const Vec3& x : other.positions) d.positions.push_back(x + Vec3(5.0, 0.0, 0.0));
  for (const mesh::Triangle& t : other.triangles)  // faces downwards
    d.triangles.push_back({t[1] + shift, t[0] + shift, t[2] + shift});
  std::swap(d.triangles[3][0], d.triangles[3][1]);
  std::swap(d.triangles[first][0], d.triangles[first][1]);
  std::swap(d.triangles[first + 5][0], d.triangles[first + 5][1]);
  const mesh::SurfaceMesh mesh(d);
  CHECK(mesh.component_count() == 2);
  CHECK(mesh.reoriented_count() == 3);
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    CHECK(mesh.rest_normal(t).z() * (static_cast<std::size_t>(t) < first ? 1.0 : -1.0) == relative(1.0));
}

TEST_CASE(
    "a Moebius strip has joints of two triangles, whatever its orientation; the same strip without its twist has "
    "none") {
  CHECK(mesh::SurfaceMesh(strip(9, false)).joints().empty());
  const mesh::SurfaceMesh first(strip(9, true));
  REQUIRE(first.joints().size() > 0);
  CHECK(first.component_count() == 1);
  mesh::MeshData turned = strip(9, true);
  for (std::size_t t = 0; t < turned.triangles.size(); t += 3)
    std::swap(turned.triangles[t][1], turned.triangles[t][2]);
  for (const mesh::MeshData& again : {turned, first.data()}) {
    const mesh::SurfaceMesh mesh(again);
    REQUIRE(mesh.joints().size() == first.joints().size());
    for (std::size_t j = 0; j < mesh.joints().size(); ++j) CHECK(mesh.joints()[j].edge == first.joints()[j].edge);
  }
  CHECK(mesh::SurfaceMesh(first.data()).reoriented_count() == 0);
}

TEST_CASE("an edge of three triangles is a joint, and refused by its names where the rest shape is apart") {
  mesh::MeshData d =
      data_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
  d.vertex_tags = {11, 12, 13, 14, 15};
  d.triangle_tags = {101, 102, 103};
  const mesh::SurfaceMesh mesh(d);
  REQUIRE(mesh.joints().size() == 1);
  CHECK(mesh.joints()[0].edge == mesh::Segment{0, 1});
  CHECK(mesh.joints()[0].sides.size() == 3);
  CHECK(mesh.component_count() == 1);
  for (const mesh::TriangleSide& s : mesh.joints()[0].sides) {
    CHECK(mesh.neighbour(s.triangle, s.side) == no_index);
    CHECK(mesh.is_joint(s.triangle, s.side));
    CHECK(!mesh.is_joint(s.triangle, (s.side + 1) % 3));
  }
  for (const mesh::Triangle& t : d.triangles)
    d.rest.push_back({d.positions[t[0]], d.positions[t[1]], d.positions[t[2]]});
  const std::string text = refusal(d);
  CHECK(contains(text, "sheet.msh"));
  CHECK(contains(text, "11-12"));
  CHECK(contains(text, "triangles 101, 102, 103"));
  CHECK(contains(text, "1 edge(s)"));
}

TEST_CASE("a flange keeps one orientation across its web") {
  const double degree = std::numbers::pi / 180.0;
  mesh::MeshData d = fan({0.0, 185.0 * degree, 90.0 * degree}, Pattern::diagonal, 3, 3);
  const std::vector<Index> left = d.groups[2].triangles;
  for (const bool turned : {false, true}) {
    if (turned)
      for (const Index t : left) std::swap(d.triangles[t][1], d.triangles[t][2]);
    const mesh::SurfaceMesh mesh(d);
    CHECK(mesh.joints().size() == 3);
    CHECK((mesh.reoriented_count() > 0) == turned);
    for (const Index t : left) CHECK(mesh.rest_normal(t).dot(mesh.rest_normal(0)) > 0.9);
    CHECK(mesh::SurfaceMesh(mesh.data()).reoriented_count() == 0);
  }
}

TEST_CASE("duplicate triangles are refused by name, whatever their orientation") {
  for (const mesh::Triangle& again : {mesh::Triangle{0, 1, 2}, mesh::Triangle{2, 1, 0}, mesh::Triangle{1, 2, 0}}) {
    mesh::MeshData d = data_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}, again});
    d.triangle_tags = {21, 22, 23};
    const std::string text = refusal(d);
    CHECK(contains(text, "duplicate"));
    CHECK(contains(text, "21 and 23"));
  }
}

TEST_CASE("degenerate triangles are refused by name") {
  mesh::MeshData d = data_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}});
  d.triangle_tags = {31, 32};
  REQUIRE(refusal(d).empty());
  SUBCASE("collinear") {
    d.positions[3] = Vec3(2.0, -1.0, 0.0);
  }
  SUBCASE("collinear to round-off, far from the origin") {
    for (Vec3& x : d.positions) x = Vec3(1000.0, 500.0, 0.0) + 0.1 * x;
    d.positions[3] = d.positions[1] + (d.positions[2] - d.positions[1]) / 3.0;
  }
  SUBCASE("coinciding vertices") {
    d.positions[3] = d.positions[1];
  }
  SUBCASE("repeated vertex") {
    d.triangles[1] = {1, 3, 1};
  }
  SUBCASE("a coordinate that is no number") {
    d.positions[3].z() = std::numeric_limits<double>::quiet_NaN();
  }
  SUBCASE("an infinite coordinate") {
    d.positions[3].x() = std::numeric_limits<double>::infinity();
  }
  const std::string text = refusal(d);
  CHECK(contains(text, "degenerate"));
  CHECK(contains(text, ": 32;"));
}

TEST_CASE("a small but sound triangle is no degenerate one") {
  mesh::MeshData d = grid(2, 2, false, 0.0);
  for (Vec3& x : d.positions) x *= 1e-6;
  CHECK(refusal(d).empty());
}

TEST_CASE("vertices without a triangle, and triangles without their vertex, are refused") {
  mesh::MeshData d = data_of({{0, 0, 0}, {1, 0, 0}, {5, 5, 5}, {0, 1, 0}}, {{0, 1, 3}});
  d.vertex_tags = {1, 2, 77, 4};
  CHECK(contains(refusal(d), "1 vertex(es) belong to no triangle: 77"));
  CHECK(contains(refusal(data_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}})), "does not exist"));
  CHECK(contains(refusal(data_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {})), "no triangles"));
}

TEST_CASE("long lists of culprits are cut short") {
  mesh::MeshData d = data_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  for (int i = 0; i < 12; ++i) d.positions.push_back({1.0 * i, 7.0, 0.0});
  CHECK(contains(refusal(d), "12 vertex(es) belong to no triangle: 4, 5, 6, 7, 8, 9, 10, 11 and 4 more"));
}

TEST_CASE("groups are found by name and dimension, an unknown name lists those there are") {
  mesh::MeshData d = square(Pattern::diagonal, 3);
  d.groups.push_back({"tip", 0, {5}, {}, {}});
  const mesh::SurfaceMesh mesh(d);
  CHECK(mesh.has_group("left"));
  CHECK_FALSE(mesh.has_group("Left"));
  CHECK(mesh.group("left").segments.size() == 3);
  CHECK(mesh.group("tip", 0).vertices == std::vector<Index>{5});
  const auto message = [&](const std::string& name, int dimension) -> std::string {
    try {
      (void)mesh.group(name, dimension);
    } catch (const UserError& e) {
      return e.what();
    }
    return {};
  };
  const std::string any = message("lefft", -1);
  for (const char* name : {"'lefft'", "'left'", "'right'", "'bottom'", "'top'", "'tip'"}) CHECK(contains(any, name));
  const std::string curve = message("tip", 1);  // it exists, but is a point
  CHECK(contains(curve, "no curve group 'tip'"));
  CHECK(contains(curve, "'left'"));
  CHECK(contains(message("left", 2), "the mesh has: none"));
}

TEST_CASE("a line element that is no edge is refused") {
  mesh::MeshData d = grid(2, 2, false, 0.0);
  d.groups.push_back({"cut", 1, {0, 2}, {{0, 2}}, {}});
  d.vertex_tags = {10, 20, 30, 40, 50, 60, 70, 80, 90};
  const std::string text = refusal(d);
  CHECK(contains(text, "group 'cut'"));
  CHECK(contains(text, "10-30"));
  d.groups[0].segments = {{1, 0}};
  CHECK(refusal(d).empty());
}

TEST_CASE("area, normal, corners and extent") {
  const mesh::SurfaceMesh mesh(data_of({{1, 2, 3}, {4, 2, 3}, {1, 2, 7}}, {{0, 1, 2}}));
  CHECK(mesh.area(0) == relative(6.0).epsilon(1e-15));
  CHECK((mesh.rest_normal(0) - Vec3(0, -1, 0)).norm() < 1e-15);
  CHECK(mesh.rest_corner(0, 2) == Vec3(1, 2, 7));
  CHECK(mesh.extent() == relative(5.0).epsilon(1e-15));
  CHECK(mesh.component_count() == 1);
}

}  // namespace test_surface_mesh

// Shape of triangles, vertices that coincide, rigid-body motions that supports leave free, material axes.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "energy/sheet.hpp"
#include "mesh/coincident.hpp"
#include "mesh/quality.hpp"
#include "system/rigid_motions.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_mesh_quality {

using namespace voile;
using namespace voile::testing;

namespace {

constexpr double degree = std::numbers::pi / 180.0;
using Kind = system::Support::Kind;

/// A strip of cells of the given aspect, all cut the same way, with inner vertices moved by a fraction of a cell.
mesh::SurfaceMesh cells(double aspect, double jitter) {
  return mesh::SurfaceMesh(
      mapped(grid(8, 8, false, jitter), [&](const Vec3& x) { return Vec3(aspect * x[0], x[1], 0); }));
}

double largest_unevenness(const mesh::SurfaceMesh& mesh) {
  double largest = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) largest = std::max(largest, mesh::shape_of(mesh, t).unevenness);
  return largest;
}

/// A second copy of the unit square beside (or on) the first one, none of its vertices shared.
mesh::MeshData two_squares(int n, const Vec3& shift) {
  mesh::MeshData d = square(Pattern::diagonal, n);
  const mesh::MeshData other = d;
  const auto first = static_cast<Index>(d.positions.size());
  for (const Vec3& x : other.positions) d.positions.push_back(x + shift);
  for (const mesh::Triangle& t : other.triangles) d.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  for (mesh::Group g : other.groups) {
    g.name = "other " + g.name;
    for (Index& v : g.vertices) v += first;
    for (mesh::Segment& s : g.segments) s = {s[0] + first, s[1] + first};
    d.groups.push_back(g);
  }
  return d;
}

std::vector<system::FreePiece> free_of(const mesh::SurfaceMesh& mesh, const std::vector<system::Support>& supports) {
  return system::free_pieces(mesh, system::resolve_supports(mesh, supports));
}

/// Motions that are left to a single piece: translations and rotations; {0, 0}: held.
std::pair<int, int> left(const mesh::SurfaceMesh& mesh, const std::vector<system::Support>& supports) {
  const auto free = free_of(mesh, supports);
  REQUIRE(free.size() <= 1);
  return free.empty() ? std::pair{0, 0} : std::pair{free[0].translations, free[0].rotations};
}

/// The unit square with point groups at three corners.
mesh::MeshData with_corners(int n) {
  mesh::MeshData d = square(Pattern::diagonal, n);
  d.groups.push_back({"a", 0, {0}, {}, {}});
  d.groups.push_back({"b", 0, {n}, {}, {}});
  d.groups.push_back({"c", 0, {n * (n + 1)}, {}, {}});
  return d;
}

system::Support held(const std::string& group, bool x, bool y, bool z) {
  system::Support s = support(group, Kind::displacement);
  s.components = {x, y, z};
  return s;
}

}  // namespace

TEST_CASE("shape: angles, aspect and unevenness of triangles that are known") {
  mesh::MeshData d;
  d.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}};
  d.triangles = {{0, 1, 2}};
  const mesh::TriangleShape equal = mesh::shape_of(mesh::SurfaceMesh(d), 0);
  CHECK(equal.smallest_angle == relative(60 * degree).epsilon(1e-14));
  CHECK(equal.aspect == relative(2.0 / std::sqrt(3.0)).epsilon(1e-14));
  CHECK(equal.unevenness == 0.0);
  d.positions[2] = {0.5, 1e-6, 0};
  const mesh::TriangleShape sliver = mesh::shape_of(mesh::SurfaceMesh(d), 0);
  CHECK(sliver.smallest_angle == relative(std::atan(2e-6)).epsilon(1e-9));
  CHECK(sliver.aspect == relative(1e6).epsilon(1e-9));
  for (const double aspect : {1.0, 8.0, 50.0}) {
    CHECK(largest_unevenness(cells(aspect, 0.0)) < 1e-12);
    CHECK(largest_unevenness(cells(aspect, 0.2)) > 0.2);
  }
  // The same on a fold: the neighbour is unfolded.
  mesh::MeshData folded;
  folded.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0.6, 0.8}};
  folded.positions[3] = Vec3(0.5, 0.5, 0) + Vec3(0.5, 0.5, 0).norm() * Vec3(0, 0, 1);
  folded.triangles = {{0, 1, 2}, {1, 3, 2}};
  CHECK(mesh::shape_of(mesh::SurfaceMesh(folded), 0).unevenness < 1e-12);
}

TEST_CASE("coincident vertices are counted and merged, groups follow, layers stay apart") {
  const int n = 4;
  mesh::MeshData d = two_squares(n, {1, 0, 0});
  mesh::Group seam = d.groups[1];  // both sides of the slit
  const mesh::Group& lip = d.groups[4];
  REQUIRE((seam.name == "right" && lip.name == "other left"));
  seam.name = "seam";
  seam.segments.insert(seam.segments.end(), lip.segments.begin(), lip.segments.end());
  seam.vertices.insert(seam.vertices.end(), lip.vertices.begin(), lip.vertices.end());
  d.groups.push_back(seam);
  const double tolerance = mesh::default_merge_tolerance(d);
  CHECK(tolerance == relative(1e-6 * std::sqrt(5.0)));
  const mesh::Coincidence c = mesh::find_coincident(d, tolerance);
  CHECK(c.places == n + 1);
  CHECK(c.vertices == 2 * (n + 1));
  CHECK((c.low - Vec3(1, 0, 0)).norm() + (c.high - Vec3(1, 1, 0)).norm() < 1e-12);
  CHECK(mesh::SurfaceMesh(d).component_count() == 2);
  CHECK(mesh::merge_coincident(d, tolerance) == n + 1);
  const mesh::SurfaceMesh merged(d);
  CHECK(merged.component_count() == 1);
  CHECK(merged.vertex_count() == 2 * (n + 1) * (n + 1) - (n + 1));
  CHECK(merged.group("right").segments.size() == n);
  CHECK(merged.group("right").vertices == merged.group("other left").vertices);
  CHECK(merged.group("other right").vertices.size() == n + 1);
  CHECK(merged.group("seam").segments.size() == n);
  CHECK(merged.group("seam").vertices.size() == n + 1);
  CHECK(mesh::find_coincident(merged.data(), tolerance).places == 0);

  // Nearly the same place: within a tolerance that says so.
  mesh::MeshData apart = two_squares(n, {1 + 1e-4, 0, 0});
  CHECK(mesh::find_coincident(apart, tolerance).places == 0);
  CHECK(mesh::merge_coincident(apart, 2e-4) == n + 1);
  CHECK_THROWS_WITH_AS(mesh::merge_coincident(apart, 0.3), doctest::Contains("merge_tolerance"), UserError);

  // Two layers are sewn along their boundaries only.
  mesh::MeshData layers = two_squares(n, Vec3::Zero());
  CHECK(mesh::find_coincident(layers, tolerance).places == (n + 1) * (n + 1));
  CHECK(mesh::merge_coincident(layers, tolerance) == 4 * n);
}

TEST_CASE("T joints are distinguished from slits, and merged") {
  const int n = 4;
  // The second square begins in the middle of the first one, where vertices are inside.
  mesh::MeshData tee = two_squares(n, {0.5, 0, 0});
  for (std::size_t v = static_cast<std::size_t>((n + 1) * (n + 1)); v < tee.positions.size(); ++v)
    tee.positions[v] = {0.5, tee.positions[v][1], tee.positions[v][0] - 0.5};
  const double tolerance = mesh::default_merge_tolerance(tee);
  CHECK(mesh::find_coincident(tee, tolerance).joints == n - 1);
  CHECK(mesh::merge_coincident(tee, tolerance) == n + 1);
  CHECK(mesh::find_coincident(tee, tolerance).joints == 0);
  CHECK(mesh::SurfaceMesh(tee).joints().size() == n);
  CHECK(mesh::find_coincident(two_squares(n, {1, 0, 0}), tolerance).joints == 0);
  CHECK(mesh::find_coincident(two_squares(n, Vec3::Zero()), tolerance).joints == 0);
}

TEST_CASE("free rigid-body motions: nothing held, points, lines, planes and clamps") {
  const mesh::SurfaceMesh mesh(with_corners(5));
  CHECK(left(mesh, {}) == std::pair{3, 3});
  CHECK(left(mesh, {support("a", Kind::hinged)}) == std::pair{0, 3});
  CHECK(left(mesh, {support("a", Kind::hinged), support("b", Kind::hinged)}) == std::pair{0, 1});
  CHECK(left(mesh, {support("a", Kind::hinged), support("b", Kind::hinged), support("c", Kind::hinged)}) ==
        std::pair{0, 0});
  // Statically determinate: 3 + 2 + 1.
  CHECK(left(mesh, {held("a", true, true, true), held("b", false, true, true), held("c", false, false, true)}) ==
        std::pair{0, 0});
  CHECK(left(mesh, {held("a", true, true, true), held("b", true, false, true), held("c", false, false, true)}) ==
        std::pair{0, 1});
  CHECK(left(mesh, {support("left", Kind::hinged)}) == std::pair{0, 1});
  CHECK(left(mesh, {support("left", Kind::clamped)}) == std::pair{0, 0});
  CHECK(left(mesh, {held("left", true, false, true)}) == std::pair{1, 1});
  CHECK(left(mesh, {held("left", true, true, false)}) == std::pair{1, 2});
  // A mirror leaves two translations and the rotation about its normal.
  CHECK(left(mesh, {support("left", Kind::symmetry)}) == std::pair{2, 1});
  CHECK(left(mesh, {support("left", Kind::symmetry), support("bottom", Kind::symmetry)}) == std::pair{1, 0});
  const auto drifting = free_of(mesh, {support("left", Kind::symmetry), support("bottom", Kind::symmetry)});
  CHECK((drifting[0].directions.at(0).cwiseAbs() - Vec3(0, 0, 1)).norm() < 1e-9);
  CHECK(drifting[0].triangles == 50);
}

TEST_CASE("springs hold as supports do") {
  const mesh::SurfaceMesh mesh(with_corners(5));
  const auto left_by = [&](const std::string& group, const std::optional<Vec3>& direction) {
    system::Spring spring;
    spring.group = group;
    spring.stiffness = 1e-3;
    spring.direction = direction;
    const auto free = system::free_pieces(mesh, {}, {spring});
    return free.empty() ? std::pair{0, 0} : std::pair{free[0].translations, free[0].rotations};
  };
  CHECK(left_by("", std::nullopt) == std::pair{0, 0});
  CHECK(left_by("", Vec3(0, 0, 2)) == std::pair{2, 1});  // an elastic foundation lets it slide and turn
  CHECK(left_by("a", std::nullopt) == std::pair{0, 3});
  CHECK(left_by("left", std::nullopt) == std::pair{0, 1});
}

TEST_CASE("free rigid-body motions do not depend on place, size and direction of the sheet") {
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, -1).normalized());
  for (const double size : {1e-4, 1.0, 1e4}) {
    const mesh::SurfaceMesh mesh(
        mapped(with_corners(5), [&](const Vec3& x) { return Vec3(size * (turn * x + Vec3(30, -20, 10))); }));
    CHECK(left(mesh, {}) == std::pair{3, 3});
    CHECK(left(mesh, {support("left", Kind::symmetry)}) == std::pair{2, 1});  // oblique
    CHECK(left(mesh, {support("left", Kind::hinged)}) == std::pair{0, 1});
    CHECK(left(mesh, {support("left", Kind::clamped)}) == std::pair{0, 0});
  }
}

TEST_CASE("free rigid-body motions are counted for each piece, pieces that share a vertex together") {
  const mesh::SurfaceMesh apart(two_squares(3, {2, 0, 0}));
  const auto free = free_of(apart, {support("left", Kind::clamped)});
  REQUIRE(free.size() == 1);
  CHECK(free[0].motions() == 6);
  CHECK(free[0].triangles == 18);
  CHECK((free[0].centre - Vec3(2.5, 0.5, 0)).norm() < 1e-12);
  // Corner on corner: three rotations are left about it.
  mesh::MeshData touching = two_squares(3, {1, 1, 0});
  CHECK(mesh::merge_coincident(touching, 1e-6) == 1);
  const auto hanging = free_of(mesh::SurfaceMesh(touching), {support("left", Kind::clamped)});
  REQUIRE(hanging.size() == 1);
  CHECK(hanging[0].translations == 0);
  CHECK(hanging[0].rotations == 3);
  CHECK(free_of(mesh::SurfaceMesh(touching), {support("left", Kind::clamped), support("other right", Kind::clamped)})
            .empty());
}

// -------------------------------------------------------------------------------------------------- material
// directions

namespace {

energy::MaterialAxes axes_of(const mesh::SurfaceMesh& mesh, const energy::Material& m) {
  const std::vector<energy::Material> materials{m};
  return energy::material_axes(mesh, materials, energy::assign_materials(mesh, materials));
}

/// A sheet that stands upright for x < 1/2, lies flat beyond: a gutter of three planes along y.
mesh::SurfaceMesh folded_strip() {
  return mesh::SurfaceMesh(mapped(grid(12, 4, false, 0.0), [](const Vec3& x) {
    return x[0] < 0.5 ? Vec3(0.5, x[1], 0.5 - x[0]) : Vec3(x[0], x[1], 0);
  }));
}

}  // namespace

TEST_CASE("a material direction is continued across a fold to triangles that it is normal to") {
  const mesh::SurfaceMesh mesh = folded_strip();
  energy::Material m = isotropic(1, 0.3, 0.1);
  m.direction = Vec3(0, 0, 1);  // along the upright part, normal to the flat one
  const energy::MaterialAxes axes = axes_of(mesh, m);
  CHECK(axes.continued == mesh.triangle_count() / 2);
  REQUIRE(axes.of.size() == static_cast<std::size_t>(mesh.triangle_count()));
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const bool flat = std::abs(mesh.rest_normal(t)[2]) > 0.5;
    CHECK((axes.of[t] - (flat ? Vec3(-1, 0, 0) : Vec3(0, 0, 0))).norm() < 1e-12);
  }
  m.direction = Vec3(0, 1, 0);
  CHECK(axes_of(mesh, m).of.empty());
  // The other half by a material of its own: no direction is there to continue.
  mesh::MeshData d = mesh.data();
  d.groups.push_back({"flat", 2, {}, {}, {}});
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    if (std::abs(mesh.rest_normal(t)[2]) > 0.5) d.groups.back().triangles.push_back(t);
  const mesh::SurfaceMesh grouped(d);
  m.direction = Vec3(0, 0, 1);
  m.groups = {"flat"};
  std::vector<energy::Material> two{m, isotropic(1, 0.3, 0.1)};
  CHECK_THROWS_WITH_AS(static_cast<void>(energy::material_axes(grouped, two, energy::assign_materials(grouped, two))),
                       doctest::Contains("normal"), UserError);
}

TEST_CASE("a material direction in texture coordinates follows the flat piece round a cylinder") {
  mesh::MeshData d = grid(24, 6, false, 0.0);
  for (const mesh::Triangle& t : d.triangles) {
    std::array<Vec2, 3> uv;
    for (int i = 0; i < 3; ++i) uv[i] = 0.3 * Vec2(d.positions[t[i]][1], d.positions[t[i]][0]);  // v runs round
    d.texture.push_back(uv);
  }
  // One triangle the other way round: its texture corners turn with it.
  std::swap(d.triangles[7][1], d.triangles[7][2]);
  std::swap(d.texture[7][1], d.texture[7][2]);
  const mesh::SurfaceMesh mesh(
      mapped(d, [](const Vec3& x) { return Vec3(std::cos(6 * x[0]), std::sin(6 * x[0]), x[1]); }));
  CHECK(mesh.reoriented_count() == 1);
  energy::Material m = isotropic(1, 0.3, 0.1);
  m.texture_direction = Vec2(0, 1);
  energy::MaterialAxes axes = axes_of(mesh, m);
  CHECK(axes.continued == 0);
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const Vec3 c = mesh::centroid(mesh, t);
    CHECK(axes.of[t].dot(Vec3(-c[1], c[0], 0).normalized()) == relative(1.0).epsilon(2e-2));
    CHECK(std::abs(axes.of[t][2]) < 1e-9);
  }
  m.texture_direction = Vec2(1, 0);
  axes = axes_of(mesh, m);
  for (const Vec3& axis : axes.of) CHECK(axis[2] == relative(1.0).epsilon(1e-9));
  CHECK_THROWS_WITH_AS(static_cast<void>(axes_of(folded_strip(), m)), doctest::Contains("texture"), UserError);
}

}  // namespace test_mesh_quality

// Unfolding of patches and rings, mirror points, frames and dihedral angles.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <set>

#include "mesh/patch.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_unfolding {

using namespace voile;
using namespace voile::testing;

namespace {

const Eigen::AngleAxisd turn(0.8, Vec3(1.0, -2.0, 0.7).normalized());

/// A flat mesh somewhere in space.
mesh::MeshData tilted_sheet() {
  return mapped(square(Pattern::jittered, 7), [](const Vec3& x) { return Vec3(turn * x + Vec3(0.3, 2.0, -1.0)); });
}

/// All boundary sides of a curve group with the same reflection.
std::vector<mesh::MirrorSide> mirrored(const mesh::SurfaceMesh& mesh, const std::string& group,
                                       const std::function<Mat3(Index)>& reflection) {
  std::vector<mesh::MirrorSide> sides;
  for (const mesh::Segment& s : mesh.group(group, 1).segments)
    for (Index t : mesh.triangles_of_vertex(s[0]))
      if (mesh.side_of(t, s[0], s[1]) >= 0) sides.push_back({t, mesh.side_of(t, s[0], s[1]), reflection(t)});
  return sides;
}

Mat3 householder(const Vec3& normal) {
  return Mat3::Identity() - 2.0 * normal * normal.transpose();
}
Mat3 half_turn(const Vec3& normal) {
  return 2.0 * normal * normal.transpose() - Mat3::Identity();
}

/// Two triangles that share the y axis, the second one folded up by an angle.
mesh::MeshData folded_pair(double angle) {
  mesh::MeshData d;
  d.source = "fold";
  d.positions = {{0, 0, 0}, {0, 1, 0}, {-0.7, 0.4, 0}, {0.9 * std::cos(angle), 0.3, 0.9 * std::sin(angle)}};
  d.triangles = {{0, 1, 2}, {1, 0, 3}};
  return d;
}

}  // namespace

TEST_CASE("unfolding keeps the distances to the edge and crosses it") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> d(-1.0, 1.0);
  const auto point = [&] { return Vec3(d(random), d(random), d(random)); };
  for (int i = 0; i < 50; ++i) {
    const Vec3 a = point(), b = point(), x = point();
    const double angle = 3.0 * d(random);
    const Vec2 pa(d(random), d(random)), pb = pa + (b - a).norm() * Vec2(std::cos(angle), std::sin(angle));
    const Vec2 p = mesh::unfold(a, b, pa, pb, x);
    CHECK((p - pa).norm() == relative((x - a).norm()).epsilon(1e-12));
    CHECK((p - pb).norm() == relative((x - b).norm()).epsilon(1e-12));
    const Vec2 e = pb - pa, q = p - pa;
    CHECK(e.x() * q.y() - e.y() * q.x() < 0.0);  // to the right of a -> b
  }
}

TEST_CASE("patches of a flat mesh are the points themselves") {
  const mesh::SurfaceMesh mesh(tilted_sheet());
  const mesh::PatchMesh patches(mesh, mirrored(mesh, "left", [&](Index) { return householder(turn * Vec3::UnitX()); }));
  int complete = 0, mirror_points = 0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const mesh::Frame frame = patches.frame(t);
    CHECK(std::abs(frame.e1.dot(frame.e2)) < 1e-15);
    CHECK((frame.e1.cross(frame.e2) - mesh.rest_normal(t)).norm() < 1e-14);
    const mesh::Patch p = patches.patch(t, frame);
    CHECK(p.area == relative(mesh.area(t)).epsilon(1e-15));
    complete += p.complete() ? 1 : 0;
    for (int i = 0; i < 6; ++i) {
      if (i < 3) CHECK(p.points[i] == mesh.triangles()[t][i]);
      if (i >= 3) CHECK(p.points[i] == patches.apex(t, i - 3));
      if (p.points[i] == no_index) {
        CHECK(mesh.neighbour(t, i - 3) == no_index);
        continue;
      }
      mirror_points += patches.is_mirror(p.points[i]) ? 1 : 0;
      CHECK((p.coordinates[i] - frame.to_plane(patches.start(p.points[i]))).norm() < 1e-14);
    }
  }
  CHECK(mirror_points == 7);
  CHECK(complete == mesh.triangle_count() - 3 * 7 + 1);  // one corner triangle has two free sides
}

TEST_CASE("a mirror point beyond a symmetry plane is the reflection of the vertex, beyond a clamped edge its turn") {
  // A curved surface that meets the plane x = 0 of the turned space.
  const mesh::SurfaceMesh mesh(mapped(square(Pattern::jittered, 5), [](const Vec3& x) {
    return Vec3(turn * Vec3(x[0], x[1], 0.3 * std::cos(2.0 * x[0]) + 0.4 * x[1] * x[1]));
  }));
  const Vec3 nu = turn * Vec3::UnitX();
  SUBCASE("symmetry") {
    const mesh::PatchMesh patches(mesh, mirrored(mesh, "left", [&](Index) { return householder(nu); }));
    REQUIRE(patches.mirrors().size() == 5);
    CHECK(patches.point_count() == mesh.vertex_count() + 5);
    for (const mesh::MirrorPoint& m : patches.mirrors()) {
      const Vec3 x = mesh.positions()[m.apex];
      CHECK(std::abs(nu.dot(x)) > 0.05);
      CHECK((m.rest - (x - 2.0 * nu.dot(x) * nu)).norm() < 1e-15);
    }
  }
  SUBCASE("clamped") {
    const mesh::PatchMesh patches(mesh,
                                  mirrored(mesh, "left", [&](Index t) { return half_turn(mesh.rest_normal(t)); }));
    REQUIRE(patches.mirrors().size() == 5);
    for (const mesh::MirrorPoint& m : patches.mirrors()) {
      const Vec3 a = mesh.positions()[m.a], b = mesh.positions()[m.b], x = mesh.positions()[m.apex];
      const Vec3 foot = (1.0 - m.foot) * a + m.foot * b;
      CHECK(std::abs((x - foot).dot(b - a)) < 1e-15);
      // In the plane of the facet, as far on the other side.
      CHECK((m.rest - (2.0 * foot - x)).norm() < 1e-15);
    }
  }
}

TEST_CASE("apexes across sides are vertices, mirror points or nothing") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 4));
  const mesh::PatchMesh patches(mesh, mirrored(mesh, "left", [](Index) { return householder(Vec3::UnitX()); }));
  int vertices = 0, mirror_points = 0, none = 0;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      const Index p = patches.apex(t, s);
      if (p == no_index) {
        ++none;
      } else if (patches.is_mirror(p)) {
        ++mirror_points;
        CHECK(patches.mirror(p).apex == mesh.triangles()[t][s]);
      } else {
        ++vertices;
        CHECK(p == mesh.apex(t, s));
      }
    }
  CHECK(mirror_points == 4);
  CHECK(none == 12);
  CHECK(vertices == 3 * mesh.triangle_count() - 16);
}

TEST_CASE("sides inside the surface and sides named twice cannot be mirrored") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 3));
  std::vector<mesh::MirrorSide> sides = mirrored(mesh, "left", [](Index) { return householder(Vec3::UnitX()); });
  sides.push_back(sides.front());
  CHECK_THROWS_AS((mesh::PatchMesh{mesh, sides}), UserError);
  sides.pop_back();
  for (int s = 0; s < 3; ++s)
    if (mesh.neighbour(0, s) != no_index) {
      sides.push_back({0, s, Mat3::Identity()});
      break;
    }
  CHECK_THROWS_AS((mesh::PatchMesh{mesh, sides}), UserError);
}

TEST_CASE("rings of a flat mesh unfold to the points themselves and are complete") {
  const mesh::SurfaceMesh mesh(tilted_sheet());
  const mesh::PatchMesh patches(mesh, mirrored(mesh, "left", [&](Index) { return householder(turn * Vec3::UnitX()); }));
  int mirror_points = 0;
  for (Index t = 0; t < mesh.triangle_count(); t += 5)
    for (int side = -1; side < 3; ++side)
      for (int rings = 1; rings <= 3; ++rings) {
        const mesh::Frame frame = patches.frame(t);
        const auto points = patches.unfolded_rings(t, side, rings, frame);
        std::set<Index> found;
        for (const auto& p : points) {
          CHECK((p.coordinates - frame.to_plane(patches.start(p.point))).norm() < 1e-13);
          found.insert(p.point);
          mirror_points += patches.is_mirror(p.point) ? 1 : 0;
        }
        CHECK(found.size() == points.size());
        if (side >= 0) {
          for (Index v : mesh.triangles()[t]) CHECK(found.count(v) == 1);
          if (mesh.apex(t, side) != no_index) CHECK(found.count(mesh.apex(t, side)) == 1);
          continue;
        }
        std::set<Index> expected(mesh.triangles()[t].begin(), mesh.triangles()[t].end());
        for (int r = 0; r < rings; ++r) {
          const std::set<Index> core = expected;
          for (Index v : core)
            for (Index k : mesh.triangles_of_vertex(v))
              expected.insert(mesh.triangles()[k].begin(), mesh.triangles()[k].end());
        }
        for (Index v : expected) CHECK(found.count(v) == 1);
        for (Index v : found)
          if (!patches.is_mirror(v)) CHECK(expected.count(v) == 1);
      }
  CHECK(mirror_points > 20);
}

TEST_CASE("rings of a cylinder unfold to its development") {
  // Vertices on generators: the facets between two generators are planar, so the faceted surface develops exactly, with
  // the chord as its width.
  constexpr int around = 9, along = 5;
  constexpr double radius = 2.0, step = 0.25, height = 0.4;
  mesh::MeshData d = grid(around, along, true, 0.0);
  const auto column = [](const Vec3& x) { return std::round(x[0] * around); };
  std::vector<Vec2> developed;
  for (Vec3& x : d.positions) {
    const double i = column(x), phi = step * i, z = height * along * x[1] + 0.07 * i * x[1];
    developed.push_back({2.0 * radius * std::sin(0.5 * step) * i, z});
    x = Vec3(radius * std::sin(phi), z, radius * std::cos(phi));
  }
  const mesh::SurfaceMesh mesh(d);
  const mesh::PatchMesh patches(mesh, {});
  for (Index t = 0; t < mesh.triangle_count(); t += 3) {
    const mesh::Triangle& v = mesh.triangles()[t];
    // e2 along the generators: the axes of the development, up to its origin.
    const mesh::Frame frame = patches.frame(t, Vec3(mesh.rest_normal(t).cross(-Vec3::UnitY())));
    CHECK((frame.e2 - Vec3::UnitY()).norm() < 1e-14);
    const Vec2 origin = (developed[v[0]] + developed[v[1]] + developed[v[2]]) / 3.0;
    for (const auto& p : patches.unfolded_rings(t, -1, 3, frame))
      CHECK((p.coordinates - (developed[p.point] - origin)).norm() < 1e-12);
    const mesh::Patch patch = patches.patch(t, frame);
    for (int i = 0; i < 6; ++i)
      if (patch.points[i] != no_index)
        CHECK((patch.coordinates[i] - (developed[patch.points[i]] - origin)).norm() < 1e-12);
  }
}

TEST_CASE("a frame follows its direction and refuses one along the normal") {
  mesh::MeshData d = folded_pair(0.4);
  d.triangle_tags = {41, 42};
  const mesh::SurfaceMesh mesh(d);
  const mesh::PatchMesh patches(mesh, {});
  const mesh::Frame f = patches.frame(0, Vec3(1.0, 1.0, 5.0));
  CHECK((f.e1 - Vec3(1.0, 1.0, 0.0).normalized()).norm() < 1e-15);
  CHECK((f.normal - Vec3::UnitZ()).norm() < 1e-15);
  CHECK(f.to_plane((mesh.rest_corner(0, 0) + mesh.rest_corner(0, 1) + mesh.rest_corner(0, 2)) / 3.0).norm() < 1e-15);
  std::string text;
  try {
    (void)patches.frame(0, Vec3(0.0, 0.0, -3.0));
  } catch (const UserError& e) {
    text = e.what();
  }
  CHECK(text.find("normal to triangle 41") != std::string::npos);
  CHECK_NOTHROW((void)patches.frame(1, Vec3(0.0, 0.0, -3.0)));
}

TEST_CASE("a folded pair: dihedral angle and patch") {
  for (const double angle : {0.0, 0.3, 1.2, 2.5, -0.9}) {
    const mesh::SurfaceMesh mesh(folded_pair(angle));
    const mesh::PatchMesh patches(mesh, {});
    const int side = mesh.side_of(0, 0, 1);
    CHECK(patches.rest_dihedral(0, side) == relative(std::abs(angle)).scale(1.0).epsilon(1e-14));
    CHECK(patches.rest_dihedral(1, mesh.side_of(1, 0, 1)) == relative(std::abs(angle)).scale(1.0).epsilon(1e-14));
    CHECK(patches.rest_dihedral(0, (side + 1) % 3) == 0.0);
    const mesh::Frame frame = patches.frame(0);
    const mesh::Patch p = patches.patch(0, frame);
    CHECK((p.coordinates[3 + side] - frame.to_plane(Vec3(0.9, 0.3, 0.0))).norm() < 1e-15);  // the fold is undone
  }
}

}  // namespace test_unfolding

// Fabric whose stiffness depends on the direction, on remeshed sheets: material axes and energies of uniform strains.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "base/decompositions.hpp"
#include "energy/sheet.hpp"
#include "extent.hpp"
#include "mesh/panels.hpp"
#include "test_adapt_kit.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"

namespace test_remeshed_fabric {

using namespace voile;
using namespace voile::testing;
using Field = std::function<Vec3(const Vec3&)>;

namespace {

constexpr double pi = std::numbers::pi;

/// A fabric eight times stiffer along its warp, which lies at `warp` [rad] to material axis 1.
energy::Material fabric(double warp, double factor = 1.0) {
  energy::Material m = isotropic(1e3, 0.3, 1e-3, 100.0);
  m.membrane = factor * energy::rotated_stiffness(energy::orthotropic_membrane(8e5, 1e5, 0.2, 3e4, 1e-3), warp);
  return m;
}

double membrane_energy(const mesh::SurfaceMesh& mesh, const std::vector<energy::Material>& materials, const Field& u) {
  system::ModelInput input;
  input.materials = materials;
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector();
  set_displacement(model, a, [&](Index v) { return u(mesh.positions()[v]); });
  return system::energies(model, a).membrane;
}

/// Largest angle between material axis 1 of the triangles, carried from their charts to the start shape, and the
/// direction that it should have at their middle there [rad].
double axis_error(const mesh::SurfaceMesh& mesh, const std::vector<energy::Material>& materials,
                  const std::function<Vec3(Index, const Vec3&)>& expected) {
  system::ModelInput input;
  input.materials = materials;
  const system::Model model(PETSC_COMM_WORLD, mesh, input);
  const energy::Sheet& sheet = model.discretisation().sheet();
  double worst = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    Eigen::Matrix<double, 3, 2> chart, start;
    Vec3 middle = Vec3::Zero();
    for (int i = 0; i < 3; ++i) middle += mesh.start_corner(t, i) / 3.0;
    for (int i = 1; i < 3; ++i) {
      chart.col(i - 1) = mesh.rest_corner(t, i) - mesh.rest_corner(t, 0);
      start.col(i - 1) = mesh.start_corner(t, i) - mesh.start_corner(t, 0);
    }
    const Vec3 axis = start * LeastSquares(chart).solve(sheet.frame(t).e1);
    const Vec3 normal = start.col(0).cross(start.col(1)).normalized(), wanted = expected(t, middle);
    const Vec3 in_plane = wanted - wanted.dot(normal) * normal;
    worst = std::max(worst, std::atan2(axis.cross(in_plane).norm(), axis.dot(in_plane)));
  }
  return worst;
}

/// A remeshed sheet, finer and coarser in places, with operations of all kinds.
mesh::SurfaceMesh changed(const mesh::SurfaceMesh& first, double size) {
  const RestSurface rest(first);
  const auto h =
      sizes(first, [&](const Vec3& x) { return size * (1.0 + 0.8 * std::sin(5 * x[0] + 4 * x[1] + 3 * x[2])); });
  const Remeshed r = remeshed(first, rest, h);
  REQUIRE(r.counts.splits > 20);
  REQUIRE(r.counts.collapses > 10);
  REQUIRE(r.counts.smoothed > 20);
  return mesh::SurfaceMesh(r.mesh);
}

/// Surface groups "left half" and "right half" of a sheet, by a wavy border through the middles of triangles.
void add_halves(mesh::MeshData& d, const std::function<bool(const Vec3&)>& is_left) {
  mesh::Group left{"left half", 2, {}, {}, {}}, right{"right half", 2, {}, {}, {}};
  for (Index t = 0; t < static_cast<Index>(d.triangles.size()); ++t) {
    Vec3 middle = Vec3::Zero();
    for (Index v : d.triangles[t]) middle += d.positions[v] / 3.0;
    (is_left(middle) ? left : right).triangles.push_back(t);
  }
  for (mesh::Group* g : {&left, &right}) d.groups.push_back(*g);
}

bool is_left(const Vec3& x) {
  return x[0] < 0.5;
}

/// Two pieces cut at angles of their own: texture coordinates turned by 0.7 and -2.1 rad, lying over each other.
Vec2 in_piece(bool left, const Vec3& x) {
  return (Eigen::Rotation2Dd(left ? 0.7 : -2.1) * x.head<2>()).eval() + Vec2(3.0, 1.0);
}

mesh::MeshData two_pieces() {
  mesh::MeshData d = square(Pattern::diagonal, extent(16, 8));
  add_halves(d, is_left);
  for (const mesh::Triangle& t : d.triangles) {
    const Vec3 middle = (d.positions[t[0]] + d.positions[t[1]] + d.positions[t[2]]) / 3.0;
    d.texture.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) d.texture.back()[i] = in_piece(is_left(middle), d.positions[t[i]]);
  }
  return d;
}

/// A uniform strain in the plane with a rigid motion.
Vec3 stretched(const Vec3& x) {
  Mat3 f = Mat3::Identity();
  f.topLeftCorner<2, 2>() << 1.01, 0.015, -0.004, 0.98;
  return Eigen::AngleAxisd(0.6, Vec3(1, 2, 2).normalized()) * (f * x) - x;
}

}  // namespace

TEST_CASE("flat fabric: a remeshed sheet stores the same in a uniform strain, with its axes where they were") {
  const energy::Material plain = fabric(0.4);
  SUBCASE("a direction") {
    energy::Material m = plain;
    m.direction = Vec3(0.8, 0.6, 0.3);
    const mesh::SurfaceMesh first(square(Pattern::gmsh, extent(16, 8))), next = changed(first, extent(0.05, 0.1));
    const double before = membrane_energy(first, {m}, stretched);
    CHECK(membrane_energy(next, {m}, stretched) == relative(before).epsilon(1e-12));
    CHECK(axis_error(next, {m}, [](Index, const Vec3&) { return Vec3(0.8, 0.6, 0.0); }) < 1e-7);
    m.direction = Vec3(0.6, 0.8, 0.3);  // it matters where the axis is
    CHECK(std::abs(membrane_energy(next, {m}, stretched) / before - 1.0) > 0.01);
  }
  SUBCASE("two materials, divided by a border that is not straight") {
    mesh::MeshData d = square(Pattern::gmsh, extent(16, 8));
    add_halves(d, [](const Vec3& x) { return x[0] < 0.5 + 0.1 * std::sin(9 * x[1]); });
    std::vector<energy::Material> two{plain, fabric(1.1, 30.0)};
    two[0].groups = {"left half"};
    two[1].groups = {"right half"};
    two[0].direction = Vec3(1, 0, 0);
    two[1].direction = Vec3(0, 1, 0);
    const mesh::SurfaceMesh first(d), next = changed(first, extent(0.05, 0.1));
    // Where the border bends it is a curve, so that areas change a little; on each side of it nothing else does.
    CHECK(group_area(next, "right half") == relative(group_area(first, "right half")).epsilon(extent(3e-3, 3e-2)));
    for (const mesh::SurfaceMesh* mesh : {&first, &next}) {
      double sum = 0.0;
      for (energy::Material m : two) {
        const double fraction = group_area(*mesh, m.groups[0]);
        m.groups.clear();
        sum += fraction * membrane_energy(*mesh, {m}, stretched);
      }
      CHECK(membrane_energy(*mesh, two, stretched) == relative(sum).epsilon(1e-12));
    }
  }
  SUBCASE("two pieces with textures of their own, as charts or on the surface in space") {
    for (const bool charts : {false, true}) {
      CAPTURE(charts);
      mesh::MeshData d = two_pieces();
      if (charts) mesh::take_rest_from_texture(d, 1.0);
      const mesh::SurfaceMesh first(d), next = changed(first, extent(0.05, 0.1));
      for (const bool textured : {true, false}) {
        CAPTURE(textured);
        if (!textured && !charts) continue;  // a direction in space has no pieces
        energy::Material m = plain;
        if (textured) m.texture_direction = Vec2(0.8, 0.6);
        if (!textured) m.direction = Vec3(0.8, 0.6, 0.0);  // in the chart, which is the texture
        CHECK(membrane_energy(next, {m}, stretched) == relative(membrane_energy(first, {m}, stretched)).epsilon(1e-10));
        const auto expected = [](Index, const Vec3& x) -> Vec3 {
          const Vec2 axis = Eigen::Rotation2Dd(is_left(x) ? -0.7 : 2.1) * Vec2(0.8, 0.6);
          return {axis[0], axis[1], 0.0};
        };
        CHECK(axis_error(next, {m}, expected) < 1e-7);
      }
    }
  }
}

namespace {

/// Half a cylinder of radius 1 and length 1 about z.
Vec3 on_cylinder(const Vec3& x) {
  return {std::cos(pi * x[0]), std::sin(pi * x[0]), x[1]};
}

Vec3 around(const Vec3& x) {
  return Vec3(-x[1], x[0], 0.0) / std::hypot(x[0], x[1]);
}

constexpr double wider = 1.02, longer = 0.99;

/// The cylinder gets wider and shorter: uniform strains along and around it.
Vec3 inflated(const Vec3& x) {
  return {(wider - 1.0) * x[0], (wider - 1.0) * x[1], (longer - 1.0) * x[2]};
}

/// What that stores in a strip of unit length between two angles, if material axis 1 lies at `angle(phi)` to the way
/// around.
double exact(const energy::Material& m, double from, double to, const std::function<double(double)>& angle) {
  const Vec3 strain(0.5 * (wider * wider - 1.0), 0.5 * (longer * longer - 1.0), 0.0);
  constexpr int steps = 400;
  double sum = 0.0;
  for (int k = 0; k < steps; ++k) {
    const Mat3 a = energy::rotated_stiffness(m.membrane, angle(from + (to - from) * (k + 0.5) / steps));
    sum += 0.5 * strain.dot(a * strain) * (to - from) / steps;
  }
  return sum;
}

}  // namespace

// Remeshed twice, which takes six minutes with sanitizers, through the code of the test before.
TEST_CASE("fabric of a curved rest shape: axes and energies are those of the surface, more closely on a finer mesh" *
          doctest::skip(extent(false, true))) {
  mesh::MeshData d = square(Pattern::gmsh, 24);
  for (const mesh::Triangle& t : d.triangles) {
    d.texture.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& x = d.positions[t[i]];
      d.texture.back()[i] = Eigen::Rotation2Dd(0.9) * Vec2(pi * x[0], x[1]);
    }
  }
  add_halves(d, is_left);
  const mesh::SurfaceMesh first(mapped(std::move(d), on_cylinder));
  const mesh::SurfaceMesh same = changed(first, 0.12), finer = changed(first, 0.08);
  const Vec3 skew(1.0, 0.2, 0.7);
  energy::Material by_direction = fabric(0.4), by_texture = by_direction;
  by_direction.direction = skew;
  by_texture.texture_direction = Vec2(0.8, 0.6);
  const double in_sheet = std::atan2(0.6, 0.8) - 0.9;  // from the way around to the axis
  const auto axis_of = [&](bool textured) {
    return [=](Index, const Vec3& x) -> Vec3 {
      if (!textured) return skew;
      return std::cos(in_sheet) * around(x) + std::sin(in_sheet) * Vec3::UnitZ();
    };
  };
  const auto angle_of = [&](bool textured) {
    return [=](double phi) {
      if (textured) return in_sheet;
      return std::atan2(skew[2], skew.dot(around({std::cos(phi), std::sin(phi), 0.0})));
    };
  };
  for (const bool textured : {false, true}) {
    CAPTURE(textured);
    const energy::Material& m = textured ? by_texture : by_direction;
    const double whole = exact(m, 0.0, pi, angle_of(textured));
    CHECK(axis_error(first, {m}, axis_of(textured)) < 0.01);
    CHECK(axis_error(same, {m}, axis_of(textured)) < 0.02);
    CHECK(axis_error(finer, {m}, axis_of(textured)) < 0.02);
    CHECK(membrane_energy(first, {m}, inflated) == relative(whole).epsilon(6e-3));
    CHECK(membrane_energy(same, {m}, inflated) == relative(whole).epsilon(5e-3));
    CHECK(membrane_energy(finer, {m}, inflated) == relative(whole).epsilon(3e-3));
    std::vector<energy::Material> two{m, m};
    two[0].groups = {"left half"};
    two[1].groups = {"right half"};
    two[1].membrane *= 20.0;
    const double both = exact(two[0], 0.0, pi / 2, angle_of(textured)) + exact(two[1], pi / 2, pi, angle_of(textured));
    CHECK(membrane_energy(same, two, inflated) == relative(both).epsilon(5e-3));
  }
}

}  // namespace test_remeshed_fabric

// Ease of a sheet round and above bodies, and what probes of garments record, on any number of ranks.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "base/mpi.hpp"
#include "record/probes.hpp"
#include "system/contact.hpp"
#include "system/ease.hpp"
#include "test_model_kit.hpp"
#include "voile/errors.hpp"

namespace test_ease {

using namespace voile;
using namespace voile::testing;

namespace {

constexpr double radius = 0.3, gap = 0.07;

/// Half a tube of fabric, `gap` away from a limb along z.
mesh::SurfaceMesh half_tube() {
  return mesh::SurfaceMesh(mapped(square(Pattern::union_jack, 8), [](const Vec3& x) {
    const double angle = std::numbers::pi * x[0];
    return Vec3((radius + gap) * std::cos(angle), (radius + gap) * std::sin(angle), x[1]);
  }));
}

contact::Obstacle limb() {
  contact::Obstacle o;
  o.name = "limb";
  o.shape = contact::Obstacle::Shape::capsule;
  o.points = {{0, 0, -0.5}, {0, 0, 1.5}};
  o.radius = radius;
  o.motion = [](const Vec3&, double t) { return Vec3(0, -t, 0); };
  return o;
}

contact::Obstacle ground(double level) {
  contact::Obstacle o;
  o.name = "ground";
  o.shape = contact::Obstacle::Shape::plane;
  o.points = {{0, 0, level}};
  return o;
}

/// A wall of two triangles in the plane y = -1, of some thickness.
contact::Obstacle wall(double thickness) {
  contact::Obstacle o;
  o.name = "wall";
  o.points = {{-5, -1, -5}, {5, -1, -5}, {5, -1, 5}, {-5, -1, 5}};
  o.triangles = {{0, 1, 2}, {0, 2, 3}};
  o.thickness = thickness;
  return o;
}

system::ModelInput beside(std::vector<contact::Obstacle> obstacles) {
  system::ModelInput in;
  in.materials = {isotropic(1e4, 0.3, 1e-3, 1.0)};
  in.contact.active = true;
  in.contact.options.distance = 1e-3;
  in.contact.obstacles = std::move(obstacles);
  return in;
}

}  // namespace

TEST_CASE("ease: fabric round a limb keeps its gap; a limb that goes away, a wall and the ground") {
  const mesh::SurfaceMesh mesh = half_tube();
  system::Model model(PETSC_COMM_WORLD, mesh, beside({ground(-0.01), limb()}));
  const petsc::VecHandle rest = model.dofs().create_vector();
  const bool root = mpi::rank(PETSC_COMM_WORLD) == 0;
  for (const double t : {0.0, 0.05}) {
    model.set_time(t);
    const std::vector<double> ease = system::ease(model.contact()->scene(), rest);
    REQUIRE(ease.size() == (root ? mesh.positions().size() : 0));
    for (std::size_t v = 0; v < ease.size(); ++v) {
      const Vec3& x = mesh.positions()[v];
      CHECK(ease[v] == doctest::Approx(std::hypot(x[0], x[1] + t) - radius).epsilon(1e-12));
    }
  }
  system::Model other(PETSC_COMM_WORLD, mesh, beside({wall(0.2), limb()}));
  petsc::VecHandle moved = other.dofs().create_vector();
  set_displacement(other, moved, [](Index) { return Vec3(0, -0.8, 0); });
  const std::vector<double> ease = system::ease(other.contact()->scene(), moved);
  for (std::size_t v = 0; v < ease.size(); ++v) {
    const Vec3& x = mesh.positions()[v];
    const double to_limb = std::abs(std::hypot(x[0], x[1] - 0.8) - radius), to_wall = std::abs(x[1] + 0.2 - 0.1);
    CHECK(ease[v] == doctest::Approx(std::min(to_limb, to_wall)).epsilon(1e-9));
  }
  CHECK(system::has_bodies(other.contact()->scene().input()));
  CHECK_FALSE(system::has_bodies(beside({ground(0.0)}).contact));
}

TEST_CASE("probes of ease and height: columns and values") {
  const mesh::SurfaceMesh mesh = half_tube();
  system::Model model(PETSC_COMM_WORLD, mesh, beside({limb()}));
  input::Case c;
  using Kind = input::Probe::Kind;
  c.probes = {{"all", Kind::ease, "", {}, {}}, {"hem", Kind::height, "bottom", {}, {}, -0.5}};
  c.probes.push_back({"side", Kind::height, "left", {}, {1}});
  const record::Probes probes(c, model);
  CHECK(probes.columns() == std::vector<std::string>{"all_min", "all_mean", "hem_min", "hem_mean", "hem_max",
                                                     "side_min", "side_mean", "side_max"});
  CHECK(probes.need_ease());
  CHECK_FALSE(probes.need_energies());
  petsc::VecHandle u = model.dofs().create_vector();
  // The hem falls on one side.
  set_displacement(model, u, [&](Index v) { return Vec3(0, 0, 0.1 * mesh.positions()[v][0]); });
  system::Model bare(PETSC_COMM_WORLD, mesh, beside({ground(-1.0)}));
  CHECK_THROWS_AS(record::Probes(c, bare), UserError);
  record::Observed state{model.dofs().gather(u), {}, {}, system::ease(model.contact()->scene(), u)};
  if (mpi::rank(PETSC_COMM_WORLD) != 0) return;
  const std::vector<double> values = probes.values(state, model);
  REQUIRE(values.size() == 8);
  const double fallen = 0.1 * (radius + gap);
  for (const auto& [k, exact] : {std::pair{0, gap}, {1, gap}, {2, 0.5 - fallen}, {3, 0.5}, {4, 0.5 + fallen}, {5, 0.0}})
    CHECK(values[static_cast<std::size_t>(k)] == doctest::Approx(exact).epsilon(1e-9));
}

}  // namespace test_ease

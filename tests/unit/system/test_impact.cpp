// What hits an obstacle in one step of time does not leave it faster than it came, however long the step.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "contact/barrier.hpp"
#include "solve/time_integration.hpp"
#include "system/contact.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"

namespace test_impact {

using namespace voile;
using namespace voile::testing;
using contact::Obstacle;
using LoadKind = system::Load::Kind;

namespace {

constexpr double drop = 0.04, distance = 1e-3, weight = 0.3 * 9.81;

/// A square of side 1 that floats `height` above a floor, under its weight.
system::ModelInput above_floor(double height, double friction) {
  Obstacle floor;
  floor.name = "floor";
  floor.shape = Obstacle::Shape::plane;
  floor.points = {Vec3(0.0, 0.0, -height)};
  floor.friction = friction;
  system::ModelInput in;
  in.materials = {isotropic(1e5, 0.3, 1e-3, 0.3)};
  in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))};
  in.contact.active = true;
  in.contact.options = {distance, 1e4, 1e-3};
  in.contact.obstacles = {floor};
  return in;
}

solve::TimeOptions steps(double end, double step, double radius) {
  solve::TimeOptions o = motion_options(end, step);
  o.radius = radius;
  return o;
}

struct Heights {
  double lowest, highest_after;  ///< of all vertices, against the start [m]
  int warnings = 0;              ///< of the radius
};

Heights fall(double step, double radius, system::Mass mass) {
  const mesh::SurfaceMesh mesh(grid(4, 4, true, 0.0));
  system::Model model(PETSC_COMM_WORLD, mesh, above_floor(drop, 0.3));
  const petsc::VecHandle u = model.dofs().create_vector(), v = model.dofs().create_vector();
  system::DynamicsOptions options;
  options.mass = mass;
  system::Dynamics dynamics(model, options);
  solve::TimeIntegration time(dynamics, steps(0.5, step, radius));
  Heights h{0.0, -drop};
  time.on_remark([&](const std::string& text) { h.warnings += text.find("radius") != std::string::npos ? 1 : 0; });
  bool hit = false;
  const Ended end = follow_from(state_of(u, v), time, [&](const system::State& s, const solve::StepResult&) {
    double low = 0.0, high = -drop;
    for (const Vec3& w : per_vertex(model, s.u)) {
      low = std::min(low, w[2]);
      high = std::max(high, w[2]);
    }
    hit = hit || low < -drop + distance;
    h.lowest = std::min(h.lowest, low);
    if (hit) h.highest_after = std::max(h.highest_after, high);
    return false;
  });
  CAPTURE(end.reason);
  REQUIRE(end.completed);
  return h;
}

}  // namespace

TEST_CASE("a sheet that falls flat on a floor does not rise above where it began") {
  for (const double step : {0.0025, 0.005, 0.01, 0.02})
    for (const system::Mass mass : {system::Mass::lumped, system::Mass::consistent}) {
      CAPTURE(step);
      const Heights h = fall(step, 0.0, mass);
      CHECK(h.lowest < -drop + distance);
      CHECK(h.lowest > -drop);
      CHECK(h.highest_after < 0.0);
      CHECK(h.warnings == 0);
    }
}

TEST_CASE("with a spectral radius of 0.5 it may, by up to twice its speed: why that is not the default") {
  const Heights h = fall(0.01, 0.5, system::Mass::lumped);
  CHECK(h.highest_after > 0.0);
  CHECK(h.highest_after < 3.0 * drop);
  CHECK(h.warnings == 1);
}

TEST_CASE("what lies on a floor stays at rest, with either mass, whatever its accelerations were made of") {
  for (const system::Mass mass : {system::Mass::lumped, system::Mass::consistent}) {
    const mesh::SurfaceMesh mesh(grid(3, 3, true, 0.05));
    double low = 0.5 * distance, high = distance;  // of the gap at which the barrier carries the weight
    for (int k = 0; k < 200; ++k) {
      const double g = 0.5 * (low + high);
      (-1e4 * contact::barrier(g, distance).first > weight ? low : high) = g;
    }
    system::Model model(PETSC_COMM_WORLD, mesh, above_floor(low, 0.0));
    const petsc::VecHandle u = model.dofs().create_vector(), v = model.dofs().create_vector();
    system::DynamicsOptions options;
    options.mass = mass;
    system::Dynamics dynamics(model, options);
    solve::TimeIntegration time(dynamics, steps(0.2, 0.01, 0.0));
    double farthest = 0.0;
    const Ended end = follow_from(state_of(u, v), time, [&](const system::State& s, const solve::StepResult&) {
      for (const Vec3& w : per_vertex(model, s.u)) farthest = std::max(farthest, w.norm());
      return false;
    });
    REQUIRE(end.completed);
    CHECK(farthest < 1e-8);
  }
}

}  // namespace test_impact

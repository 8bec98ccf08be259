// Where the energy of a motion goes, against answers that are known.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/mpi.hpp"
#include "contact/barrier.hpp"
#include "solve/time_integration.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_energy_balance {

using namespace voile;
using namespace voile::testing;
using contact::Obstacle;
using system::EnergyBalance;
using LoadKind = system::Load::Kind;
using SupportKind = system::Support::Kind;

namespace {

constexpr double gravity = 9.81, density = 0.5, distance = 1e-3, stiffness = 1e4;

/// A strip 1 x 0.25 that is free and light.
mesh::MeshData strip() {
  mesh::MeshData d = grid(8, 2, false, 0.0);
  add_square_groups(d);
  return mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.25 * x[1], 0.0); });
}
constexpr double mass = 0.25 * density;

system::ModelInput free_strip() {
  system::ModelInput in;
  in.materials = {isotropic(1e5, 0.3, 0.01, density)};
  return in;
}

struct Motion {
  mesh::SurfaceMesh mesh{strip()};
  system::Model model;
  petsc::VecHandle u, v;

  explicit Motion(const system::ModelInput& in)
      : model(PETSC_COMM_WORLD, mesh, in), u(model.dofs().create_vector()), v(model.dofs().create_vector()) {}

  /// The balance at the end, whose sum is checked against the energies there.
  EnergyBalance run(solve::TimeOptions o, const system::DynamicsOptions& d = {}) {
    const Option rtol("-snes_rtol", "1e-12"), stol("-snes_stol", "1e-12");
    o.energy_balance = true;
    system::Dynamics dynamics(model, d);
    solve::TimeIntegration time(dynamics, o);
    const Ended end = follow_from(state_of(u, v), time);
    CAPTURE(end.reason);
    REQUIRE(end.completed);
    const EnergyBalance& b = end.state.balance;
    REQUIRE(b.kept);
    const double held = dynamics.kinetic_energy_of_held(v, system::short_moment * o.step);
    CHECK(b.kinetic == relative(dynamics.kinetic_energy(v) + held).epsilon(1e-12));
    const double gained = b.kinetic + b.stored - b.initial,
                 told = b.loads + b.supports + b.obstacles - b.damping - b.drag - b.friction - b.numerical;
    CHECK(std::abs(gained - told - b.unaccounted) < 1e-12 * b.turnover());
    CHECK(std::abs(b.unaccounted) < 1e-6 * b.turnover());
    CHECK(b.remeshing == 0.0);
    return b;
  }
  void push(const Vec3& velocity) {
    set_displacement(model, v, [&](Index) { return velocity; });
  }
};

solve::TimeOptions steps(double end, double step, double radius) {
  solve::TimeOptions o = motion_options(end, step);
  o.radius = radius;
  return o;
}

/// The gap at which a floor carries the weight.
double resting_gap() {
  double low = 0.5 * distance, high = distance;
  for (int k = 0; k < 200; ++k) {
    const double g = 0.5 * (low + high);
    (-stiffness * contact::barrier(g, distance).first > density * gravity ? low : high) = g;
  }
  return low;
}

/// On a floor that is a half-space, or a plate of two triangles.
system::ModelInput on_floor(Obstacle::Shape shape, double friction, const std::function<Vec3(double)>& motion = {}) {
  Obstacle floor;
  floor.name = "floor";
  floor.shape = shape;
  const double z = -resting_gap();
  floor.points = {Vec3(0.0, 0.0, z)};
  if (shape == Obstacle::Shape::mesh) {
    floor.points = {Vec3(-3.0, -3.0, z), Vec3(4.0, -3.0, z), Vec3(4.0, 4.0, z), Vec3(-3.0, 4.0, z)};
    floor.triangles = {{0, 1, 2}, {0, 2, 3}};
  }
  floor.friction = friction;
  if (motion) floor.motion = [motion](const Vec3&, double t) { return motion(t); };
  system::ModelInput in = free_strip();
  in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -gravity))};
  in.contact.active = true;
  in.contact.options = {distance, stiffness, 1e-4};
  in.contact.obstacles = {floor};
  return in;
}

}  // namespace

TEST_CASE("a free oscillation loses energy to the scheme only: hardly any with radius 1, with radius 0 what is gone") {
  const auto swing = [](double end, double step, double radius) {
    system::ModelInput in = free_strip();
    in.supports = {support("left", SupportKind::clamped)};
    Motion m(in);
    set_displacement(m.model, m.v, [&](Index i) {
      const double x = m.mesh.positions()[i][0];
      return Vec3(0.0, 0.0, 0.1 * x * x);
    });
    solve::TimeOptions o = steps(end, step, radius);
    const EnergyBalance b = m.run(o);
    CHECK(b.loads == 0.0);
    CHECK(std::abs(b.supports) < 1e-12 * b.initial);
    CHECK(b.damping == 0.0);
    CHECK(b.numerical == relative(b.initial - b.kinetic - b.stored).epsilon(1e-5));
    return b.numerical / b.initial;
  };
  CHECK(std::abs(swing(1.6, 0.04, 1.0)) < 5e-5);
  const double lost = swing(16.0, 0.8, 0.0);
  CHECK(lost > 0.02);
  CHECK(swing(16.0, 0.4, 0.0) < 0.3 * lost);
}

TEST_CASE("what falls under drag gives the air the work of its weight but for its motion") {
  system::ModelInput in = free_strip();
  in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -gravity))};
  Motion m(in);
  system::DynamicsOptions d;
  d.drag.normal = 1.3;
  d.drag.air_density = 1.2;
  const double end = 1.0, terminal = std::sqrt(density * gravity / (0.5 * 1.2 * 1.3)),
               fraction = gravity * end / terminal;
  const EnergyBalance b = m.run(steps(end, 0.002, 1.0), d);
  const double height = terminal * terminal / gravity * std::log(std::cosh(fraction)),
               speed = terminal * std::tanh(fraction);
  CHECK(b.loads == relative(mass * gravity * height).epsilon(0.005));
  CHECK(b.drag == relative(mass * (gravity * height - 0.5 * speed * speed)).epsilon(0.01));
  CHECK(std::abs(b.numerical) < 0.01 * b.loads);
  CHECK(b.damping == 0.0);
}

TEST_CASE("damping takes what it takes, also with the explicit method") {
  for (const auto method :
       {solve::TimeOptions::Method::implicit_alpha, solve::TimeOptions::Method::central_difference}) {
    Motion m(free_strip());
    m.push(Vec3(0.3, 0.0, 0.2));
    system::DynamicsOptions d;
    d.mass_damping = 2.0;
    solve::TimeOptions o = steps(0.5, 0.001, 1.0);
    o.method = method;
    const EnergyBalance b = m.run(o, d);
    CHECK(b.initial == relative(0.5 * mass * 0.13).epsilon(1e-9));
    CHECK(b.damping == relative(b.initial * (1.0 - std::exp(-2.0))).epsilon(0.005));
    CHECK(std::abs(b.numerical) < 0.005 * b.initial);
  }
  // Of bending and of the membrane: what is gone.
  system::ModelInput in = free_strip();
  in.supports = {support("left", SupportKind::clamped)};
  for (const bool bending : {true, false}) {
    Motion m(in);
    set_displacement(m.model, m.v, [&](Index i) {
      const double x = m.mesh.positions()[i][0];
      return bending ? Vec3(0.0, 0.0, 0.1 * x * x) : Vec3(0.1 * x, 0.0, 0.0);
    });
    system::DynamicsOptions d;
    d.bending_damping = bending ? 1.0 : 0.0;
    d.viscous_time = bending ? 0.0 : 0.02;
    const EnergyBalance b = m.run(bending ? steps(2.0, 0.005, 1.0) : steps(0.01, 2e-5, 1.0), d);
    CHECK(b.damping > 0.2 * b.initial);
    CHECK(b.damping == relative(b.initial - b.kinetic - b.stored).epsilon(0.03));
  }
}

TEST_CASE("what slides to rest on a floor gives its energy to friction: mu m g d") {
  constexpr double mu = 0.3, speed = 0.2;
  for (const auto shape : {Obstacle::Shape::plane, Obstacle::Shape::mesh}) {
    Motion m(on_floor(shape, mu));
    system::DynamicsOptions damped;
    damped.mass_damping = 50.0;
    (void)m.run(steps(0.2, 0.001, 0.0), damped);  // on a plate of triangles it starts somewhat out of balance
    m.push(Vec3(speed, 0.0, 0.0));
    const EnergyBalance b = m.run(steps(0.12, 0.0005, 0.0));
    const double way = per_vertex(m.model, m.u)[0][0];
    CHECK(way == relative(0.5 * speed * speed / (mu * gravity)).epsilon(0.02));
    CHECK(b.friction == relative(mu * mass * gravity * way).epsilon(0.02));
    CHECK(b.friction == relative(0.5 * mass * speed * speed).epsilon(0.02));
    CHECK(std::abs(b.obstacles) < 1e-9 * b.initial);
  }
}

TEST_CASE("what friction holds starts at rest: a motion from there has no acceleration that friction would take") {
  constexpr double mu = 0.5;
  for (const auto shape : {Obstacle::Shape::plane, Obstacle::Shape::mesh}) {
    system::ModelInput in = on_floor(shape, mu);
    in.loads.push_back(load(LoadKind::line, "right", Vec3(2.0 * mu * mass * gravity, 0.0, 0.0)));  // half of what slips
    Motion m(in);
    system::DynamicsOptions damped;
    damped.mass_damping = 50.0;
    const double before = m.run(steps(0.3, 0.005, 0.0), damped).kinetic;
    const EnergyBalance b = m.run(steps(0.005, 0.005, 0.0), damped);
    CAPTURE(before);
    CHECK(b.kinetic < 2.0 * before);
    CHECK(b.damping >= 0.0);
  }
}

TEST_CASE("a floor that moves does work: it lifts what lies on it, and drags it along") {
  for (const auto shape : {Obstacle::Shape::plane, Obstacle::Shape::mesh}) {
    constexpr double acceleration = 2.0, end = 0.2, speed = acceleration * end, height = 0.5 * speed * end;
    Motion lifted(on_floor(shape, 0.0, [](double t) { return Vec3(0.0, 0.0, 0.5 * acceleration * t * t); }));
    const EnergyBalance up = lifted.run(steps(end, 0.001, 0.0));
    CHECK(up.obstacles == relative(mass * (gravity * height + 0.5 * speed * speed)).epsilon(0.01));
    CHECK(up.loads == relative(-mass * gravity * height).epsilon(0.01));
    CHECK(std::abs(up.numerical) < 0.02 * up.obstacles);
    CHECK(up.friction == 0.0);

    constexpr double mu = 0.3, belt = 0.2;
    Motion dragged(on_floor(shape, mu, [](double t) { return Vec3(belt * t, 0.0, 0.0); }));
    const EnergyBalance along = dragged.run(steps(0.12, 0.0005, 0.0));
    CHECK(along.obstacles == relative(mass * belt * belt).epsilon(0.02));
    CHECK(along.friction == relative(0.5 * mass * belt * belt).epsilon(0.02));
    CHECK(along.kinetic == relative(0.5 * mass * belt * belt).epsilon(0.02));
  }
}

TEST_CASE("supports that move and clamps that turn do work") {
  constexpr double acceleration = 2.0, end = 0.4, speed = acceleration * end;
  system::ModelInput in = free_strip();
  in.supports = {support("left", SupportKind::hinged)};
  in.supports[0].motion = [](const Vec3&, double t) { return Vec3(0.5 * acceleration * t * t, 0.0, 0.0); };
  Motion pulled(in);
  system::DynamicsOptions d;
  d.viscous_time = 1e-3;  // for the waves of the beginning
  d.mass = system::Mass::lumped;
  const EnergyBalance b = pulled.run(steps(end, 0.001, 0.0), d);
  // The vertices of the edge, with half a cell of eight, are the support's, and have their energy from it.
  CHECK(b.supports == relative(0.5 * mass * speed * speed).epsilon(0.02));

  in.supports = {support("left", SupportKind::clamped)};
  in.supports[0].rotation = [](double t) {
    return Mat3(Eigen::AngleAxisd(0.4 * std::pow(std::sin(1.2 * t), 2), Vec3::UnitY()));
  };
  in.supports[0].motion = [](const Vec3&, double) { return Vec3(0.0, 0.0, 0.0); };
  Motion turned(in);
  const EnergyBalance t = turned.run(steps(1.0, 0.005, 1.0));
  CHECK(t.kinetic + t.stored > 0.0);
  CHECK(t.supports == relative(t.kinetic + t.stored).epsilon(0.03));
}

TEST_CASE("a motion that is left and taken up again goes on with its balance; a change between is told") {
  system::ModelInput in = free_strip();
  in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -gravity))};
  in.supports = {support("left", SupportKind::clamped)};
  Motion whole(in), part(in);
  const EnergyBalance all = whole.run(steps(0.2, 0.01, 0.5));
  solve::TimeOptions o = steps(0.2, 0.01, 0.5);
  o.energy_balance = true;
  o.until = 0.1;
  const Option rtol("-snes_rtol", "1e-12"), stol("-snes_stol", "1e-12");
  system::Dynamics dynamics(part.model, {});
  solve::TimeIntegration first(dynamics, o);
  Ended half = follow_from(state_of(part.u, part.v), first);
  REQUIRE(half.completed);
  const std::vector<double> numbers = system::numbers_of(half.state.balance);
  CHECK(numbers.size() == system::balance_numbers);
  half.state.balance = system::balance_of(numbers);
  o.until = 0.2;
  VOILE_PETSC(VecScale(half.state.v, 1.1));
  const double gain = 0.21 * half.state.balance.kinetic;
  solve::TimeIntegration again(dynamics, o);
  REQUIRE(again.begin(half.state).outcome == solve::Outcome::accepted);
  CHECK(half.state.balance.remeshing == relative(gain).epsilon(1e-9));
  VOILE_PETSC(VecScale(half.state.v, 1.0 / 1.1));
  half.state.balance = system::balance_of(numbers);
  solve::TimeIntegration second(dynamics, o);
  const Ended end = follow_from(std::move(half.state), second);
  REQUIRE(end.completed);
  CHECK(std::abs(end.state.balance.remeshing) < 1e-12 * all.turnover());
  CHECK(end.state.balance.loads == relative(all.loads).epsilon(1e-6));
  CHECK(end.state.balance.numerical == relative(all.numerical).epsilon(1e-4));
  CHECK_FALSE(system::balance_of({}).kept);
  CHECK_THROWS_AS((void)system::balance_of({1.0}), InternalError);
}

}  // namespace test_energy_balance

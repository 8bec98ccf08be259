// Motion with damping, drag and moving supports; the size of steps.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "solve/eigen.hpp"
#include "solve/time_integration.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "test_time_kit.hpp"
#include "voile/errors.hpp"

namespace test_damping {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::motion;

TEST_CASE("damping: the mass-proportional one slows a drifting sheet as exp(-alpha t)") {
  system::ModelInput in = Falling::input();
  in.supports.clear();
  in.loads.clear();
  Falling f(in);
  set_displacement(f.model, f.v, [](Index) { return Vec3(0.0, 0.0, 1.0); });
  DynamicsOptions d;
  d.mass_damping = 3.0;
  const std::vector<double> end = integrate(f, d, motion_options(0.5, 0.005));
  const double expected = std::exp(-1.5);
  for (std::size_t i = end.size() / 2 + 2; i < end.size(); i += 3) CHECK(end[i] == relative(expected).epsilon(1e-3));
}

TEST_CASE("damping of bending leaves springs to the ground alone") {
  system::ModelInput in = Falling::input();
  in.supports.clear();
  in.loads.clear();
  system::Spring spring;
  spring.kind = system::Spring::Kind::area;
  spring.stiffness = 4000.0;
  in.springs = {spring};
  Falling f(in);
  set_displacement(f.model, f.v, [](Index) { return Vec3(0.0, 0.0, 1.0); });
  DynamicsOptions d;
  d.bending_damping = 1e-2;
  // As a rigid body it swings with omega^2 = k / m per area, undamped.
  const double omega = std::sqrt(4000.0 / in.materials[0].areal_density), end = 6.5 / omega;
  const std::vector<double> moved = integrate(f, d, motion_options(end, end / 400));
  for (std::size_t i = 2; i < moved.size() / 2; i += 3)
    CHECK(moved[i] * omega == relative(std::sin(6.5)).epsilon(2e-3));
}

TEST_CASE("a sheet that hangs and swings loses amplitude as its material's damping of bending says") {
  // Damped by a matrix C, a mode phi of mass 1 decays as exp(-phi.C phi t / 2) while that is slow. Without gravity C is
  // beta times the stiffness of the mode, and the damping ratio beta omega / 2; with it a part of beta only counts.
  for (const double gravity : {0.0, 9.81}) {
    CAPTURE(gravity);
    system::ModelInput in = Falling::input();
    in.materials[0].bending_damping = gravity > 0.0 ? 0.25 : 0.05;
    in.loads = {load(LoadKind::gravity, "", Vec3(gravity, 0.0, 0.0))};  // along the strip: it hangs straight
    Falling f(in);
    f.model.conditions().set_load_factor(1.0);
    solve::Newton newton(f.model);
    REQUIRE(newton.step(f.u).converged);
    DynamicsOptions d;
    d.mass = system::Mass::consistent;
    const Dynamics weighing(f.model, d);
    const solve::EigenResult modes = solve::vibration_modes(f.model, f.u, 1, d.mass);
    REQUIRE(modes.modes.size() == 1);
    const Vec mode = modes.modes[0].shape;
    petsc::VecHandle product = f.model.dofs().create_vector(), rest = f.model.dofs().create_vector();
    VOILE_PETSC(VecCopy(f.u, rest));
    f.model.potential().constant().multiply_damping(mode, product);
    const double omega = 2.0 * M_PI * modes.modes[0].value;
    const double rate = 0.25 * dot(product, mode) / weighing.kinetic_energy(mode);
    CAPTURE(rate / omega);
    if (gravity == 0.0) CHECK(rate / omega == relative(0.5 * 0.05 * omega).epsilon(1e-3));
    REQUIRE(rate / omega > 0.01);
    REQUIRE(rate / omega < 0.1);
    const double period = 2.0 * M_PI / std::sqrt(omega * omega - rate * rate);
    TimeOptions o = motion_options(period, period / 200.0);
    o.radius = 1.0;
    const Option rtol("-snes_rtol", "1e-10");
    /// What is left of the mode after a period.
    const auto left = [&](bool damped) {
      d.material_damping = damped;
      VOILE_PETSC(VecWAXPY(f.u, 1e-4, mode, rest));
      // At the crest of a damped swing the mode is at rest.
      VOILE_PETSC(VecZeroEntries(f.v));
      (void)integrate(f, d, o);
      VOILE_PETSC(VecAXPY(f.u, -1.0, rest));
      return dot(f.u, mode) / (1e-4 * dot(mode, mode));
    };
    CHECK(left(true) == relative(std::exp(-rate * period)).epsilon(3e-3));
    CHECK(left(false) == relative(std::cos(omega * period)).epsilon(3e-3));
  }
}

TEST_CASE("damping of bending and membrane takes energy from a vibration") {
  const auto left = [](const DynamicsOptions& d, bool bending) {
    system::ModelInput in = Falling::input();
    in.loads.clear();
    Falling f(in);
    set_displacement(f.model, f.v, [&](Index i) {
      const double x = f.mesh.positions()[i][0];
      return bending ? Vec3(0.0, 0.0, 0.1 * x * x) : Vec3(0.1 * x, 0.0, 0.0);
    });
    Dynamics dynamics(f.model, d);
    TimeOptions o = motion_options(bending ? 2.0 : 0.01, bending ? 0.02 : 1e-4);
    o.radius = 1.0;
    const double before = dynamics.kinetic_energy(f.v);
    solve::TimeIntegration time(dynamics, o);
    CHECK(follow_from(state_of(f.u, f.v), time).completed);
    return (dynamics.kinetic_energy(f.v) + f.model.energy(f.u)) / before;
  };
  CHECK(left({}, true) == relative(1.0).epsilon(0.01));
  CHECK(left({}, false) == relative(1.0).epsilon(0.01));
  DynamicsOptions bending, membrane;
  bending.bending_damping = 3.0;
  membrane.viscous_time = 0.02;
  CHECK(left(bending, true) < 0.7);
  CHECK(left(membrane, false) < 0.7);
  CHECK(left(membrane, true) > 0.9);  // hardly any stretching in bending
}

TEST_CASE("viscous membrane and drag: the step's residual is the gradient of its potential") {
  system::ModelInput in = Falling::input();
  in.supports[0].kind = SupportKind::hinged;
  in.materials[0].bending_damping = 0.02;
  in.materials[0].viscous_time = 0.03;
  system::Spring spring;  // damped by nothing
  spring.kind = system::Spring::Kind::area;
  spring.stiffness = 1e6;
  in.springs = {spring};
  Falling f(in);
  DynamicsOptions d;
  d.mass_damping = 2.0;
  d.bending_damping = 0.01;
  d.viscous_time = 0.02;
  d.drag.normal = 1.5;
  d.drag.tangential = 0.3;
  d.drag.wind = Vec3(1.0, 2.0, -3.0);
  for (const system::Mass mass : {system::Mass::lumped, system::Mass::consistent}) {
    d.mass = mass;
    Dynamics dynamics(f.model, d);
    petsc::VecHandle u = f.model.dofs().create_vector(), x = f.model.dofs().create_vector(),
                     v = f.model.dofs().create_vector(), a = f.model.dofs().create_vector(),
                     r = f.model.dofs().create_vector(), other = f.model.dofs().create_vector(),
                     direction = f.model.dofs().create_vector(), difference = f.model.dofs().create_vector();
    set_displacement(f.model, u, noise(0.01, 3));
    set_displacement(f.model, v, noise(1.0, 4));
    dynamics.set_time(0.3);
    dynamics.start_step(u, v, 0.004);
    const double s_v = 300.0, s_a = 1e5;
    set_displacement(f.model, direction, noise(1.0, 5));
    f.model.dofs().clear_fixed(direction);
    // v and a are affine in x.
    const auto at = [&](double shift) {
      VOILE_PETSC(VecWAXPY(x, shift, direction, u));
      VOILE_PETSC(VecAXPY(x, 0.002, v));
      VOILE_PETSC(VecWAXPY(a, -1.0, u, x));
      VOILE_PETSC(VecCopy(a, difference));
      VOILE_PETSC(VecScale(a, s_a));
      VOILE_PETSC(VecScale(difference, s_v));
    };
    at(0.0);
    dynamics.residual(x, difference, a, r);
    const double slope = dot(r, direction), step = 1e-5;
    at(step);
    const double plus = dynamics.energy(x, difference, a, s_v, s_a);
    dynamics.residual(x, difference, a, r);
    at(-step);
    const double minus = dynamics.energy(x, difference, a, s_v, s_a);
    dynamics.residual(x, difference, a, other);
    CHECK((plus - minus) / (2.0 * step) == relative(slope).epsilon(1e-6));
    // And the tangent is the derivative of the residual.
    VOILE_PETSC(VecAXPY(r, -1.0, other));
    VOILE_PETSC(VecScale(r, 0.5 / step));
    at(0.0);
    dynamics.assemble_tangent(x, energy::Tangent::exact, s_v, s_a);
    VOILE_PETSC(MatMult(f.model.tangent().matrix(), direction, other));
    f.model.dofs().clear_fixed(r);
    f.model.dofs().clear_fixed(other);
    VOILE_PETSC(VecAXPY(other, -1.0, r));
    CHECK(norm(other) < 1e-6 * norm(r));
  }
}

TEST_CASE("a falling sheet reaches its terminal velocity, one in the wind is carried along by it") {
  // Falls flat along z; once with the wind blowing up, once across with friction along the surface.
  const auto final_velocities = [](const Vec3& wind, double tangential) {
    system::ModelInput in = Falling::input();
    in.supports.clear();
    Falling f(in);
    DynamicsOptions d;
    d.drag.normal = 1.3;
    d.drag.tangential = tangential;
    d.drag.air_density = 1.2;
    d.drag.wind = wind;
    const std::vector<double> end = integrate(f, d, motion_options(6.0, 0.02));
    std::vector<Vec3> v;
    for (std::size_t i = end.size() / 2; i < end.size(); i += 3) v.emplace_back(end[i], end[i + 1], end[i + 2]);
    return v;
  };
  // m g = 1/2 rho C_n w^2 per area, w against the air
  const double terminal = std::sqrt(0.5 * 9.81 / (0.5 * 1.2 * 1.3));
  for (const Vec3& v : final_velocities(Vec3::Zero(), 0.0)) CHECK(-v[2] == relative(terminal).epsilon(0.01));
  for (const Vec3& v : final_velocities(Vec3(0.0, 0.0, 5.0), 0.0))
    CHECK(v[2] == relative(5.0 - terminal).epsilon(0.01));
  for (const Vec3& v : final_velocities(Vec3(1.0, 0.0, 0.0), 0.5)) {
    CHECK(v[0] > 0.9);
    CHECK(v[0] < 1.01);
    CHECK(std::abs(v[1]) < 0.02);
  }
}

TEST_CASE("supports move as functions of time say, and the load follows its history") {
  system::ModelInput in = Falling::input();
  in.supports[0].kind = SupportKind::hinged;
  in.supports[0].motion = [](const Vec3& x, double t) { return Vec3(0.1 * t, 0.0, 0.02 * std::sin(20.0 * t) * x[1]); };
  Falling f(in);
  DynamicsOptions d;
  d.load_history = [](double t) { return std::min(1.0, 10.0 * t); };
  double factor = -1.0;
  Dynamics dynamics(f.model, d);
  solve::TimeIntegration time(dynamics, motion_options(0.05, 0.001));
  const auto look = [&](const system::State& s, const solve::StepResult&) {
    const std::vector<Vec3> u = per_vertex(f.model, s.u);
    for (Index v : f.mesh.group("left").vertices) {
      const Vec3 x = f.mesh.positions()[v];
      CHECK((u[v] - Vec3(0.1 * s.time, 0.0, 0.02 * std::sin(20.0 * s.time) * x[1])).norm() < 1e-14);
    }
    factor = f.model.conditions().load_factor();
    CHECK(s.load_factor == factor);
    return s.step == 30;
  };
  const Ended r = follow_from(state_of(f.u, f.v), time, look);
  CHECK_FALSE(r.completed);
  CHECK(r.reason.empty());
  CHECK(r.state.step == 30);
  CHECK(factor == relative(0.3).epsilon(1e-9));
  in.supports.push_back(in.supports[0]);
  CHECK_THROWS_AS(Falling twice(in), UserError);
}

TEST_CASE("the step follows the error that is asked for") {
  std::vector<int> steps;
  for (const double tolerance : {1e-5, 1e-6}) {
    Falling f;
    TimeOptions o = motion_options(0.3, 1e-3);
    o.max_step = 0.1;
    o.step_error = tolerance;
    o.target_iterations = 1000;
    Dynamics dynamics(f.model, {});
    solve::TimeIntegration time(dynamics, o);
    const Ended r = follow_from(state_of(f.u, f.v), time);
    CHECK(r.completed);
    CHECK(r.state.time == relative(0.3).epsilon(1e-12));
    steps.push_back(r.steps);
  }
  CHECK(steps[1] > 1.5 * steps[0]);
  CHECK(steps[1] < 4.0 * steps[0]);
}

TEST_CASE("the estimated error of a step is the error that it makes") {
  // A sheet as a whole under the force m j t: x = j t^3/6. The trapezoidal rule (radius 1) errs by j h^3/12 a step.
  const double jerk = 2.0, tolerance = 1e-5, end = 4.0;
  system::ModelInput in = Falling::input();
  in.supports.clear();
  in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, jerk))};
  Falling f(in);
  TimeOptions o = motion_options(end, 1e-3);
  o.max_step = 1.0;
  o.step_error = tolerance;
  o.target_iterations = 1000;
  o.radius = 1.0;
  DynamicsOptions d;
  d.load_history = [](double t) { return t; };
  Dynamics dynamics(f.model, d);
  solve::TimeIntegration time(dynamics, o);
  std::vector<double> taken;
  const auto look = [&](const system::State&, const solve::StepResult& r) {
    if (r.taken > 0.0) taken.push_back(r.taken);
    return false;
  };
  REQUIRE(follow_from(state_of(f.u, f.v), time, look).completed);
  // Sizes settle where the estimate is the 0.9^3 of the tolerance that next_step aims at.
  const double settled = std::cbrt(std::pow(0.9, 3) * tolerance * 12.0 / jerk);
  REQUIRE(taken.size() > 30);
  for (std::size_t i = 20; i + 2 < taken.size(); ++i) CHECK(taken[i] / settled == relative(1.0).epsilon(0.005));
  double error = 0.0;
  for (const double h : taken) error += jerk * h * h * h / 12.0;
  const double reached = per_vertex(f.model, f.u).front()[2], exact = jerk * end * end * end / 6.0;
  CHECK(std::abs(reached - exact) / error == relative(1.0).epsilon(0.02));
}

TEST_CASE("options of TS are obeyed") {
  Falling f;
  const Option dt("-ts_dt", "0.002"), end("-ts_max_time", "0.01"), adapt("-ts_adapt_type", "none");
  (void)integrate(f, {}, motion_options(1.0, 0.1), {}, 5);
  const Option type("-ts_type", "euler");
  Falling g;
  Dynamics dynamics(g.model, {});
  solve::TimeIntegration time(dynamics, motion_options(1.0, 0.1));
  CHECK_THROWS_AS((void)follow_from(state_of(g.u, g.v), time), UserError);
}

}  // namespace test_damping

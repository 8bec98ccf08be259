// Motion in time: second order from any start and after restarts, momenta, energy, damping, drag, moving supports.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "voile/base/error.hpp"
#include "voile/solve/eigen.hpp"
#include "voile/solve/time_integration.hpp"

using namespace voile;
using namespace voile::testing;
using solve::TimeOptions;
using system::Dynamics;
using system::DynamicsOptions;
using LoadKind = system::Load::Kind;
using SupportKind = system::Support::Kind;

namespace {

/// A cantilevered strip 1 x 0.25 of light cloth-like shell that begins to fall at t = 0.
struct Falling {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle u, v;

  explicit Falling(const system::ModelInput& in = input())
      : mesh(data()),
        model(PETSC_COMM_WORLD, mesh, in),
        u(model.dofs().create_vector()),
        v(model.dofs().create_vector()) {}
  static mesh::MeshData data() {
    mesh::MeshData d = grid(8, 2, false, 0.0);
    add_square_groups(d);
    return mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.25 * x[1], 0.0); });
  }
  static system::ModelInput input() {
    system::ModelInput in;
    in.materials = {isotropic(1e5, 0.3, 0.01, 0.5)};
    in.supports = {support("left", SupportKind::clamped)};
    in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))};
    return in;
  }
};

/// Runs to the end; returns the final positions and velocities on every rank.
template <class Problem>
std::vector<double> integrate(Problem& p, const DynamicsOptions& d, const TimeOptions& o, const Look& look = {},
                              int steps = -1) {
  Dynamics dynamics(p.model, d);
  solve::TimeIntegration time(dynamics, o);
  const Ended r = follow_from(state_of(p.u, p.v), time, look);
  CHECK(r.completed);
  CHECK(r.reason.empty());
  if (steps >= 0) CHECK(r.steps == steps);
  std::vector<double> state = values_of(p.model, p.u);
  const std::vector<double> speed = values_of(p.model, p.v);
  state.insert(state.end(), speed.begin(), speed.end());
  return state;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double d = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) d += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(d);
}

/// Orders of convergence between three step sizes, from differences of successive solutions.
double order_of(const std::function<std::vector<double>(int steps)>& solution, int steps) {
  const std::vector<double> a = solution(steps), b = solution(2 * steps), c = solution(4 * steps);
  return std::log2(distance(a, b) / distance(b, c));
}

}  // namespace

TEST_CASE("second order in time from a state with non-zero acceleration, for every member of the family") {
  for (const bool at_end : {true, false})
    for (const double radius : {0.5, 1.0}) {
      CAPTURE(at_end);
      CAPTURE(radius);
      const Option rtol("-snes_rtol", "1e-11"), stol("-snes_stol", "1e-9");
      const double order = order_of(
          [&](int steps) {
            Falling f;
            TimeOptions o = motion_options(0.05, 0.05 / steps);
            o.radius = radius;
            o.forces_at_end = at_end;
            return integrate(f, {}, o, {}, steps);
          },
          80);
      CHECK(order > 1.9);
      CHECK(order < 2.4);
    }
}

TEST_CASE("the first acceleration is that of the equations") {
  Falling f;
  Dynamics dynamics(f.model, {});
  solve::TimeIntegration time(dynamics, motion_options(1e-6, 1e-6));
  petsc::VecHandle a = f.model.dofs().create_vector();
  const Ended r = follow_from(state_of(f.u, f.v), time);
  REQUIRE(r.completed);
  VOILE_PETSC(VecCopy(r.state.a, a));
  // A free vertex of a sheet at rest falls with g: the sheet has not bent yet.
  for (const Vec3& x : per_vertex(f.model, a)) {
    const double size = x.norm();
    if (size > 0.0) CHECK((x - Vec3(0.0, 0.0, -9.81)).norm() < 1e-3 * 9.81);
  }
}

TEST_CASE("a run continued from its middle is the unbroken run") {
  Falling whole, part;
  const TimeOptions all = motion_options(0.04, 0.001);
  std::vector<double> u, v, a;
  int step = 0;
  double at = 0.0, next = 0.0;
  const std::vector<double> end = integrate(whole, {}, all, [&](const system::State& s, const solve::StepResult&) {
    if (s.step == 17) {
      u = values_of(whole.model, s.u);
      v = values_of(whole.model, s.v);
      a = values_of(whole.model, s.a);
      step = s.step;
      at = s.time;
      next = s.next_step;
    }
    return false;
  });
  REQUIRE(step == 17);
  petsc::VecHandle acceleration = part.model.dofs().create_vector();
  part.model.dofs().scatter(u, part.u);
  part.model.dofs().scatter(v, part.v);
  part.model.dofs().scatter(a, acceleration);
  Dynamics dynamics(part.model, {});
  solve::TimeIntegration time(dynamics, all);
  system::State middle = state_of(part.u, part.v);
  middle.a = petsc::share(acceleration);
  middle.step = step;
  middle.time = at;
  middle.next_step = next;
  const Ended r = follow_from(std::move(middle), time);
  REQUIRE(r.completed);
  CHECK(r.state.step == 40);
  CHECK(r.steps == 23);
  std::vector<double> state = values_of(part.model, part.u);
  const std::vector<double> speed = values_of(part.model, part.v);
  state.insert(state.end(), speed.begin(), speed.end());
  CHECK(distance(state, end) < 1e-10 * distance(end, std::vector<double>(end.size(), 0.0)));
}

TEST_CASE("a free sheet keeps its linear and angular momentum, and loses energy only to dissipation") {
  system::ModelInput in = Falling::input();
  in.supports.clear();
  in.loads.clear();
  for (const auto membrane : {energy::MembraneOperator::six_node, energy::MembraneOperator::six_node_corrected})
    for (const auto& choice : {std::pair{system::Mass::lumped, 1.0}, std::pair{system::Mass::lumped, 0.5},
                               std::pair{system::Mass::consistent, 1.0}, std::pair{system::Mass::consistent, 0.5}}) {
      const system::Mass mass = choice.first;
      const double radius = choice.second;
      if (membrane == energy::MembraneOperator::six_node_corrected && mass == system::Mass::consistent) continue;
      in.element.membrane = membrane;
      CAPTURE(static_cast<int>(membrane));
      CAPTURE(static_cast<int>(mass));
      CAPTURE(radius);
      Falling f(in);
      // Turning, drifting and bending.
      set_displacement(f.model, f.v, [&](Index i) {
        const Vec3 x = f.mesh.positions()[i] - Vec3(0.5, 0.125, 0.0);
        return Vec3(Vec3(1.0, -2.0, 3.0).cross(x) + Vec3(0.2, 0.1, -0.3) + Vec3(0.0, 0.0, 2.0 * std::sin(7.0 * x[0])));
      });
      DynamicsOptions d;
      d.mass = mass;
      Dynamics dynamics(f.model, d);
      TimeOptions o = motion_options(0.05, 0.0005);
      o.radius = radius;
      const Option rtol("-snes_rtol", "1e-10"), stol("-snes_stol", "1e-10");
      solve::TimeIntegration time(dynamics, o);
      Vec3 momentum, spin;
      std::vector<double> energy;
      double worst = 0.0, worst_spin = 0.0;
      const auto look = [&](const system::State& s, const solve::StepResult&) {
        const Vec3 p = dynamics.momentum(s.v), l = dynamics.angular_momentum(s.u, s.v);
        if (s.step == 0) {
          momentum = p;
          spin = l;
        }
        worst = std::max(worst, (p - momentum).norm() / momentum.norm());
        worst_spin = std::max(worst_spin, (l - spin).norm() / spin.norm());
        energy.push_back(dynamics.kinetic_energy(s.v) + f.model.energy(s.u));
        return false;
      };
      REQUIRE(follow_from(state_of(f.u, f.v), time, look).completed);
      CHECK(worst < 1e-9);
      // Angular momentum is kept to the order of the method only, unless the rule is symmetric in time.
      CHECK(worst_spin < 1e-3);
      const double change = energy.back() / energy.front() - 1.0;
      MESSAGE(fmt::format("radius {}: energy {:+.2e}, angular momentum {:.1e}, momentum {:.1e}", radius, change,
                          worst_spin, worst));
      if (radius == 1.0) CHECK(std::abs(change) < 2e-3);
      if (radius < 1.0) CHECK(change < 1e-6);
    }
}

TEST_CASE("a plate in its first mode swings with the frequency of the mode") {
  Falling f;
  system::ModelInput in = Falling::input();
  in.loads.clear();
  Falling still(in);
  DynamicsOptions d;
  d.mass = system::Mass::consistent;
  const solve::EigenResult modes = solve::vibration_modes(still.model, still.u, 1, d.mass);
  REQUIRE(modes.modes.size() == 1);
  const double period = 1.0 / modes.modes[0].value;
  VOILE_PETSC(VecAXPY(still.u, 1e-4, modes.modes[0].shape));
  const std::vector<double> begin = values_of(still.model, still.u);
  TimeOptions o = motion_options(period, period / 200.0);
  o.radius = 1.0;
  const Option rtol("-snes_rtol", "1e-10");
  const std::vector<double> end = integrate(still, d, o);
  double along = 0.0, square = 0.0;
  for (std::size_t i = 0; i < begin.size(); ++i) {
    along += begin[i] * end[i];
    square += begin[i] * begin[i];
  }
  CHECK(along / square == relative(1.0).epsilon(2e-3));
}

TEST_CASE("implicit and explicit motion agree") {
  Falling implicit_sheet, explicit_sheet;
  const double end = 0.02;
  const std::vector<double> a = integrate(implicit_sheet, {}, motion_options(end, end / 200));
  TimeOptions o = motion_options(end, end);
  o.method = TimeOptions::Method::central_difference;
  const std::vector<double> b = integrate(explicit_sheet, {}, o);
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size() / 2; ++i) largest = std::max(largest, std::abs(a[i]));
  for (std::size_t i = 0; i < a.size() / 2; ++i) CHECK(std::abs(a[i] - b[i]) < 2e-3 * largest);
}

TEST_CASE("the largest frequency is that of the full eigenvalue problem, from above by a percent") {
  // Largest omega^2 of M^-1 K over the free unknowns, the columns of K taken one by one.
  Falling f;
  Dynamics dynamics(f.model, {});
  const double found = solve::largest_frequency(dynamics, f.u);
  f.model.assemble_tangent(f.u, {.kind = energy::Tangent::exact});
  const PetscInt n = f.model.dofs().unknowns();
  petsc::VecHandle x = f.model.dofs().create_vector(), y = f.model.dofs().create_vector();
  const auto column = [&](PetscInt j) {
    set_displacement(f.model, x, [&](Index v) { return j / 3 == v ? Vec3(Vec3::Unit(j % 3)) : Vec3(Vec3::Zero()); });
    f.model.dofs().clear_fixed(x);
    VOILE_PETSC(MatMult(f.model.tangent().matrix(), x, y));
    f.model.dofs().clear_fixed(y);
    const std::vector<double> values = values_of(f.model, y);
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(values.data(), n));
  };
  Eigen::MatrixXd k(n, n);
  for (PetscInt j = 0; j < n; ++j) k.col(j) = column(j);
  const std::vector<double> masses = values_of(f.model, f.model.constant().mass());
  const Eigen::VectorXd root = Eigen::Map<const Eigen::VectorXd>(masses.data(), n).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = root.asDiagonal() * k * root.asDiagonal();
  const double exact = std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues()[n - 1]);
  CHECK(exact > 1.0);
  CHECK(found >= exact);
  CHECK(found < 1.011 * exact);
}

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

TEST_CASE("a sheet that hangs and swings loses amplitude as its material's damping of bending says") {
  // Damped by a matrix C, a mode phi of mass 1 decays as exp(-phi.C phi t / 2) while that is slow. Without gravity C is
  // beta times the stiffness of the mode, and the damping ratio beta omega / 2; with it a part of beta only counts.
  for (const double gravity : {0.0, 9.81}) {
    CAPTURE(gravity);
    system::ModelInput in = Falling::input();
    in.materials[0].bending_damping = gravity > 0.0 ? 0.2 : 0.05;
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
    f.model.constant().multiply_damping(mode, product);
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

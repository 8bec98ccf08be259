// Motion in time: second order from any start and after restarts, momenta, energy, damping, drag, moving supports.
#include <doctest/doctest.h>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "base/decompositions.hpp"
#include "extent.hpp"
#include "solve/eigen.hpp"
#include "solve/time_integration.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "test_time_kit.hpp"

namespace test_time {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::motion;

namespace {

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
  for (const double radius : {0.5, 1.0}) {
    CAPTURE(radius);
    const Option rtol("-snes_rtol", "1e-11"), stol("-snes_stol", "1e-9");
    const double order = order_of(
        [&](int steps) {
          Falling f;
          TimeOptions o = motion_options(0.05, 0.05 / steps);
          o.radius = radius;
          return integrate(f, {}, o, {}, steps);
        },
        80);
    CHECK(order > 1.9);
    CHECK(order < 2.4);
  }
}

TEST_CASE("second order in time from velocities that are damped, where the first step is of backward Euler") {
  const Option rtol("-snes_rtol", "1e-11"), stol("-snes_stol", "1e-9");
  const double order = order_of(
      [](int steps) {
        Falling f;
        const std::vector<Vec3>& rest = f.mesh.positions();
        set_displacement(f.model, f.v, [&](Index i) {
          const double x = rest[static_cast<std::size_t>(i)][0];
          return Vec3(0.0, 0.0, 0.1 * x * x);
        });
        DynamicsOptions damped;
        damped.bending_damping = 1e-3;
        return integrate(f, damped, motion_options(0.05, 0.05 / steps), {}, steps);
      },
      40);
  CHECK(order > 1.8);
  CHECK(order < 2.4);
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

TEST_CASE("the first acceleration is that of the forces where these are stiff") {
  Falling f;
  const std::vector<Vec3>& rest = f.mesh.positions();
  set_displacement(f.model, f.u, [&](Index v) { return Vec3(rest[v][0] * noise(1e-2, 3)(v)); });
  DynamicsOptions options;
  options.mass = system::Mass::lumped;
  Dynamics dynamics(f.model, options);
  f.model.conditions().set_load_factor(1.0);
  petsc::VecHandle forces = f.model.dofs().create_vector();
  f.model.unbalanced_force(f.u, forces);
  VOILE_PETSC(VecPointwiseDivide(forces, forces, f.model.potential().constant().mass()));
  const std::vector<Vec3> wanted = per_vertex(f.model, forces);
  solve::TimeIntegration time(dynamics, motion_options(1e-7, 1e-7));
  const Ended r = follow_from(state_of(f.u, f.v), time);
  REQUIRE(r.completed);
  petsc::VecHandle a = f.model.dofs().create_vector();
  VOILE_PETSC(VecCopy(r.state.a, a));
  const std::vector<Vec3> found = per_vertex(f.model, a);
  double largest = 0.0, error = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].isZero()) continue;  // held
    largest = std::max(largest, wanted[i].norm());
    error = std::max(error, (found[i] + wanted[i]).norm());
  }
  CHECK(largest > 1e3);
  CHECK(error < 1e-4 * largest);
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
  middle.a = petsc::fraction(acceleration);
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
      if (extent(false, (mass == system::Mass::lumped) == (radius < 1.0))) continue;
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

namespace {

struct Drift {
  double momentum = 0.0, spin = 0.0;  ///< largest changes over the size
  double energy = 0.0;                ///< at the end, relative
};

/// Of an uneven, curved sheet that tumbles and vibrates, bending by half a radian per cell.
Drift drift_of_tumbling(const energy::ElementOptions& element, system::Mass mass, double step) {
  const mesh::SurfaceMesh mesh(mapped(grid(8, 4, false, 0.25), [](const Vec3& x) {
    return Vec3(x[0], 0.5 * x[1], 0.2 * x[0] * x[0] - 0.3 * x[0] * x[1]);
  }));
  system::ModelInput in;
  in.materials = {isotropic(1e5, 0.3, 0.01, 0.5)};
  in.element = element;
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  petsc::VecHandle u = model.dofs().create_vector(), v = model.dofs().create_vector();
  set_displacement(model, v, [&](Index i) {
    const Vec3 x = mesh.positions()[i] - Vec3(0.5, 0.25, 0.0);
    return Vec3(Vec3(2.0, -3.0, 4.0).cross(x) + Vec3(0.2, 0.1, -0.3) + Vec3(0.0, 0.0, 4.0 * std::sin(5.0 * x[0])));
  });
  DynamicsOptions d;
  d.mass = mass;
  Dynamics dynamics(model, d);
  TimeOptions o = motion_options(0.04, step);
  o.radius = 1.0;
  const Option rtol("-snes_rtol", "1e-10"), stol("-snes_stol", "1e-10");
  solve::TimeIntegration time(dynamics, o);
  Vec3 momentum, spin;
  double energy = 0.0;
  Drift drift;
  const auto look = [&](const system::State& s, const solve::StepResult&) {
    const Vec3 p = dynamics.momentum(s.v), l = dynamics.angular_momentum(s.u, s.v);
    const double e = dynamics.kinetic_energy(s.v) + model.energy(s.u);
    if (s.step == 0) {
      momentum = p;
      spin = l;
      energy = e;
    }
    drift.momentum = std::max(drift.momentum, (p - momentum).norm() / momentum.norm());
    drift.spin = std::max(drift.spin, (l - spin).norm() / spin.norm());
    drift.energy = e / energy - 1.0;
    return false;
  };
  CHECK(follow_from(state_of(u, v), time, look).completed);
  return drift;
}

}  // namespace

TEST_CASE("the corrected membrane and bending by angles keep momenta with either mass, spin to second order") {
  for (const system::Mass mass : {system::Mass::lumped, system::Mass::consistent}) {
    if (extent(false, mass == system::Mass::lumped)) continue;
    CAPTURE(static_cast<int>(mass));
    const Drift plain = drift_of_tumbling({}, mass, 5e-4);
    for (const auto bending : {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle}) {
      CAPTURE(static_cast<int>(bending));
      energy::ElementOptions element;
      element.membrane = energy::MembraneOperator::six_node_corrected;
      element.bending = bending;
      const Drift coarse = drift_of_tumbling(element, mass, 1e-3), fine = drift_of_tumbling(element, mass, 5e-4);
      MESSAGE(fmt::format("momentum {:.1e}, angular momentum {:.1e}, {:.1e}, six nodes {:.1e}, energy {:+.1e}",
                          fine.momentum, coarse.spin, fine.spin, plain.spin, fine.energy));
      CHECK(std::max(coarse.momentum, fine.momentum) < 1e-11);
      CHECK(coarse.spin / fine.spin > 3.0);
      CHECK(coarse.spin / fine.spin < 5.0);
      CHECK(fine.spin < 2.0 * plain.spin);
      CHECK(std::abs(fine.energy) < 1e-2);
    }
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
  const std::vector<double> masses = values_of(f.model, f.model.potential().constant().mass());
  const Eigen::VectorXd root = Eigen::Map<const Eigen::VectorXd>(masses.data(), n).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = root.asDiagonal() * k * root.asDiagonal();
  const double exact = std::sqrt(eigenvalues(scaled)[n - 1]);
  CHECK(exact > 1.0);
  CHECK(found >= exact);
  CHECK(found < 1.011 * exact);
}

}  // namespace test_time

// Arc length and displacement control: limit points, bifurcations, branches, ends, restart, every kind of load.
#include <doctest/doctest.h>

#include <numbers>

#include "solve/path_following.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_path_following {

using namespace voile;
using namespace voile::testing;
using Control = solve::StaticOptions::Control;
using AtCriticalPoint = solve::StaticOptions::AtCriticalPoint;
using LoadKind = system::Load::Kind;
using SupportKind = system::Support::Kind;

namespace {

struct Record {
  std::vector<Report> reports;
  std::vector<std::vector<double>> states;
  Ended result;
};

Record follow(system::Model& model, Vec a, const solve::StaticOptions& options, Vec probe, system::State start = {}) {
  Record record;
  solve::PathFollower path(model, options, probe);
  start.u = petsc::fraction(a);
  record.result = follow_from(std::move(start), path, [&](const system::State& s, const solve::StepResult& r) {
    record.reports.emplace_back(s, r, path.finished(s));
    record.states.push_back(values_of(model, s.u));
    return false;
  });
  return record;
}

/// Mean displacement of a group along one axis, as a linear function of the unknowns.
petsc::VecHandle probe_of(const system::Model& model, const std::string& group, int axis) {
  petsc::VecHandle c = model.dofs().create_vector();
  const std::vector<Index>& vertices = model.dofs().mesh().group(group).vertices;
  set_displacement(model, c, [&](Index v) {
    const bool in = std::find(vertices.begin(), vertices.end(), v) != vertices.end();
    return in ? Vec3(Vec3::Unit(axis) / static_cast<double>(vertices.size())) : Vec3(Vec3::Zero());
  });
  return c;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double d = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) d = std::max(d, std::abs(a[i] - b[i]));
  return d;
}

solve::StaticOptions arc(double step, double largest) {
  solve::StaticOptions o;
  o.control = Control::arc_length;
  o.initial_step = step;
  o.max_step = largest;
  o.target_iterations = 5;
  return o;
}

/// An arch so shallow that it snaps symmetrically: its rise is its thickness.
struct ShallowArch {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  ShallowArch() : mesh(data()), model(PETSC_COMM_WORLD, mesh, input()), a(model.dofs().create_vector()) {}
  static mesh::MeshData data() {
    mesh::MeshData d = grid(12, 2, true, 0.0);
    add_square_groups(d);
    d.groups.push_back({"crown", 0, {6, 19, 32}, {}, {}});
    return mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.2 * x[1], 0.04 * x[0] * (1.0 - x[0])); });
  }
  static system::ModelInput input() {
    system::ModelInput in = Arch::input();
    in.loads = {load(LoadKind::point, "crown", Vec3(0.0, 0.0, -0.01))};
    return in;
  }
};

/// A slender strip between a pin and a slide, pressed along its length with `force` per width at load factor 1.
struct Column {
  static constexpr double length = 10.0, bending = 1e4 * 1e-3 / 12.0;  ///< E h^3/12, nu = 0
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  explicit Column(int cells = 20)
      : mesh(data(cells)), model(PETSC_COMM_WORLD, mesh, input()), a(model.dofs().create_vector()) {}
  static mesh::MeshData data(int cells) {
    mesh::MeshData d = grid(cells, 2, false, 0.0);
    add_square_groups(d);
    return mapped(d, [](const Vec3& x) { return Vec3(length * x[0], x[1], 0.0); });
  }
  static system::ModelInput input() {
    system::ModelInput in;
    in.materials = {isotropic(1e4, 0.0, 0.1)};
    system::Support slide = support("right", SupportKind::displacement);
    slide.components = {false, true, true};
    in.supports = {support("left", SupportKind::hinged), slide};
    in.loads = {load(LoadKind::line, "right", Vec3(-euler(), 0.0, 0.0))};
    return in;
  }
  static double euler() { return std::numbers::pi * std::numbers::pi * bending / (length * length); }
};

}  // namespace

TEST_CASE("the load direction is the derivative of the residual with respect to the load factor") {
  // Dead, follower and prescribed parts together, at a deformed state.
  mesh::MeshData d = grid(5, 4, false, 0.2);
  add_square_groups(d);
  const mesh::SurfaceMesh mesh(d);
  system::ModelInput in;
  in.materials = {isotropic(1e3, 0.3, 0.05)};
  system::Support moved = support("right", SupportKind::displacement);
  moved.components = {true, false, true};
  moved.value = Vec3(0.03, 0.0, -0.02);
  in.supports = {support("left", SupportKind::clamped), moved};
  in.loads = {load(LoadKind::area, "", Vec3(0.1, -0.2, 0.3))};
  system::Load follower;
  follower.kind = LoadKind::follower_pressure;
  follower.magnitude = 0.7;
  in.loads.push_back(follower);
  follower.kind = LoadKind::follower_moment;
  follower.group = "top";
  in.loads.push_back(follower);
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                   plus = model.dofs().create_vector(), minus = model.dofs().create_vector(),
                   shifted = model.dofs().create_vector(), prescribed = model.dofs().create_vector();
  set_displacement(model, a, noise(0.01, 3));
  const double factor = 0.4, step = 1e-4;
  set_displacement(model, prescribed, [&](Index v) {
    const auto& right = mesh.group("right").vertices;
    const bool in_group = std::find(right.begin(), right.end(), v) != right.end();
    return in_group ? Vec3(0.03, 0.0, -0.02) : Vec3(Vec3::Zero());
  });
  model.conditions().set_load_factor(factor);
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  model.load_direction(a, f);
  // The supports move with the load factor; the reactions of that motion are part of the direction.
  const auto moved_residual = [&](double sign, Vec r) {
    VOILE_PETSC(VecWAXPY(shifted, sign * step, prescribed, a));
    model.conditions().set_load_factor(factor + sign * step);
    model.residual(shifted, r);
    model.dofs().clear_fixed(r);
  };
  moved_residual(1.0, plus);
  moved_residual(-1.0, minus);
  VOILE_PETSC(VecAXPY(plus, -1.0, minus));
  VOILE_PETSC(VecScale(plus, -0.5 / step));
  VOILE_PETSC(VecAXPY(plus, 1.0, prescribed));
  const double size = norm(f);
  VOILE_PETSC(VecAXPY(plus, -1.0, f));
  CHECK(norm(plus) < 1e-6 * size);
  CHECK(size > 0.0);
}

TEST_CASE("clearing fixed and free components splits a vector") {
  Strip strip(1.0);
  petsc::VecHandle free = strip.model.dofs().create_vector(), fixed = strip.model.dofs().create_vector();
  VOILE_PETSC(VecSet(free, 1.0));
  VOILE_PETSC(VecSet(fixed, 1.0));
  strip.model.dofs().clear_fixed(free);
  strip.model.dofs().clear_free(fixed);
  CHECK(dot(free, fixed) == 0.0);
  CHECK(dot(fixed, fixed) == 3.0 * static_cast<double>(strip.mesh.group("left").vertices.size()));
  CHECK(dot(free, free) + dot(fixed, fixed) == static_cast<double>(strip.model.dofs().unknowns()));
}

TEST_CASE("arc length and displacement control find the same path through a snap") {
  ShallowArch first, second;
  const petsc::VecHandle probe = probe_of(first.model, "crown", 2), other = probe_of(second.model, "crown", 2);
  solve::StaticOptions options = arc(0.1, 0.3);
  options.final_displacement = -0.045;
  const Record by_arc = follow(first.model, first.a, options, probe);
  options.control = Control::displacement;
  options.initial_step = options.max_step = 0.05;
  const Record by_displacement = follow(second.model, second.a, options, other);
  REQUIRE(by_arc.result.completed);
  REQUIRE(by_displacement.result.completed);
  CHECK(dot(probe, first.a) == relative(-0.045).epsilon(1e-9));
  CHECK(dot(other, second.a) == relative(-0.045).epsilon(1e-9));
  CHECK(by_arc.result.state.load_factor == relative(by_displacement.result.state.load_factor).epsilon(1e-6));
  CHECK(largest_difference(by_arc.states.back(), by_displacement.states.back()) < 1e-7);
  // It snaps: up, down, up again; both see the same two limit points.
  REQUIRE(by_arc.result.critical.size() == 2);
  REQUIRE(by_displacement.result.critical.size() == 2);
  for (int k = 0; k < 2; ++k) {
    CHECK(by_arc.result.critical[k].kind == solve::CriticalPoint::Kind::limit);
    CHECK(by_arc.result.critical[k].load_factor ==
          relative(by_displacement.result.critical[k].load_factor).epsilon(2e-3));
  }
  CHECK(by_arc.result.critical[0].load_factor > by_arc.result.critical[1].load_factor);
  for (const Report& report : by_arc.reports) {
    const bool between = report.step >= by_arc.result.critical[0].step && report.step < by_arc.result.critical[1].step;
    if (report.step > 0) CHECK(report.newton.negative_pivots == (between ? 1 : 0));
  }
}

TEST_CASE("every state on the arc is in equilibrium and an arc length from the one before") {
  ShallowArch arch;
  const petsc::VecHandle probe = probe_of(arch.model, "crown", 2);
  solve::StaticOptions options = arc(0.1, 0.1);
  options.target_iterations = 100;  // constant length
  options.final_displacement = -0.04;
  petsc::VecHandle residual = arch.model.dofs().create_vector(), before = arch.model.dofs().create_vector(),
                   step = arch.model.dofs().create_vector(), weighted = arch.model.dofs().create_vector();
  double length = 0.0;
  solve::PathFollower path(arch.model, options, probe);
  const auto look = [&](const system::State& s, const solve::StepResult&) {
    arch.model.conditions().set_load_factor(s.load_factor);
    arch.model.residual(s.u, residual);
    CHECK(norm(residual) < 1e-6 * std::max(1e-2, arch.model.force_scale()));
    VOILE_PETSC(VecWAXPY(step, -1.0, before, s.u));
    VOILE_PETSC(VecPointwiseMult(weighted, arch.model.potential().constant().mass(), step));
    const double taken = std::sqrt(dot(weighted, step));
    if (s.step == 1) length = taken;
    if (s.step > 1 && !path.finished(s)) CHECK(taken == relative(length).epsilon(1e-6));
    VOILE_PETSC(VecCopy(s.u, before));
    return false;
  };
  CHECK(follow_from(state_of(arch.a), path, look).completed);
}

TEST_CASE("an arc without limit points ends exactly at the final load factor, in the state of load control") {
  Strip by_arc(4.0), by_load(4.0);
  const solve::StaticOptions options = arc(0.1, 0.5);
  const Record r = follow(by_arc.model, by_arc.a, options, nullptr);
  REQUIRE(r.result.completed);
  CHECK(r.result.state.load_factor == 1.0);
  CHECK(r.reports.back().last);
  CHECK(r.result.critical.empty());
  solve::LoadPath load_control(by_load.model, {});
  REQUIRE(follow_from(state_of(by_load.a), load_control).completed);
  CHECK(largest_difference(values_of(by_arc.model, by_arc.a), values_of(by_load.model, by_load.a)) < 1e-5);
}

TEST_CASE("prescribed displacements and follower moments can be followed along an arc") {
  for (const bool follower : {false, true}) {
    CAPTURE(follower);
    mesh::MeshData d = Strip::square_strip();
    const mesh::SurfaceMesh mesh(mapped(d, [](const Vec3& x) { return Vec3(10.0 * x[0], x[1], 0.0); }));
    system::ModelInput in = Strip::input(0.0);
    in.loads.clear();
    if (follower) {
      system::Load moment;
      moment.kind = LoadKind::follower_moment;
      moment.group = "right";
      moment.magnitude = 10.0;
      in.loads = {moment};
    } else {
      system::Support lift = support("right", SupportKind::displacement);
      lift.components = {false, false, true};
      lift.value = Vec3(0.0, 0.0, 3.0);
      in.supports.push_back(lift);
    }
    system::Model arc_model(PETSC_COMM_WORLD, mesh, in), load_model(PETSC_COMM_WORLD, mesh, in);
    petsc::VecHandle a = arc_model.dofs().create_vector(), b = load_model.dofs().create_vector();
    const Record r = follow(arc_model, a, arc(0.1, 0.5), nullptr);
    REQUIRE(r.result.completed);
    solve::StaticOptions steps;
    steps.initial_step = 0.1;
    solve::LoadPath load_control(load_model, steps);
    REQUIRE(follow_from(state_of(b), load_control).completed);
    CHECK(largest_difference(values_of(arc_model, a), values_of(load_model, b)) < 1e-5);
    CHECK(r.reports.back().newton.negative_pivots == 0);  // with follower loads those of the symmetric part
  }
}

TEST_CASE("a path continues from a state in its middle as if it had never stopped") {
  ShallowArch whole, part;
  const petsc::VecHandle probe = probe_of(whole.model, "crown", 2), other = probe_of(part.model, "crown", 2);
  solve::StaticOptions options = arc(0.1, 0.1);
  options.final_displacement = -0.045;
  const Record all = follow(whole.model, whole.a, options, probe);
  REQUIRE(all.result.completed);
  // Between the limit points, where only the previous state tells the direction.
  const auto middle = static_cast<std::size_t>((all.result.critical[0].step + all.result.critical[1].step) / 2);
  system::State start;
  start.step = all.reports[middle].step;
  start.load_factor = all.reports[middle].load_factor;
  start.previous = part.model.dofs().create_vector();
  const auto set = [&](Vec v, const std::vector<double>& values) { part.model.dofs().scatter(values, v); };
  set(part.a, all.states[middle]);
  set(start.previous, all.states[middle - 1]);
  const Record rest = follow(part.model, part.a, options, other, std::move(start));
  REQUIRE(rest.result.completed);
  CHECK(rest.reports.front().step == static_cast<int>(middle));
  CHECK(rest.reports[1].load_factor < rest.reports[0].load_factor);
  CHECK(rest.result.state.load_factor == relative(all.result.state.load_factor).epsilon(1e-6));
  CHECK(largest_difference(rest.states.back(), all.states.back()) < 1e-7);
  REQUIRE(rest.result.critical.size() == 1);
}

TEST_CASE("a perfect column: Euler's load is a bifurcation where the path stops or takes a branch") {
  Column straight, stopped, left, right;
  solve::StaticOptions options = arc(0.3, 0.3);
  options.final_load_factor = 1.5;
  const Record pass = follow(straight.model, straight.a, options, nullptr);
  REQUIRE(pass.result.completed);
  REQUIRE(pass.result.critical.size() == 1);
  CHECK(pass.result.critical[0].kind == solve::CriticalPoint::Kind::bifurcation);
  CHECK(pass.result.critical[0].load_factor == relative(1.0).epsilon(0.01));
  for (std::size_t i = 2; i < pass.states.back().size(); i += 3) CHECK(std::abs(pass.states.back()[i]) < 1e-9);

  options.at_critical_point = AtCriticalPoint::stop;
  const Record stop = follow(stopped.model, stopped.a, options, nullptr);
  CHECK(stop.result.completed);
  CHECK(stop.reports.back().mode != nullptr);
  CHECK(stop.result.state.load_factor == relative(1.0).epsilon(0.01));

  options.at_critical_point = AtCriticalPoint::switch_branch;
  options.final_load_factor = 1.1;
  options.max_step = 1e9;
  const Record up = follow(left.model, left.a, options, nullptr);
  options.branch_step = -1.0;
  const Record down = follow(right.model, right.a, options, nullptr);
  REQUIRE(up.result.completed);
  REQUIRE(down.result.completed);
  const petsc::VecHandle mean = left.model.dofs().create_vector();
  set_displacement(left.model, mean, [](Index) { return Vec3(Vec3::UnitZ() / 63.0); });
  const double w = dot(mean, left.a), opposite = dot(mean, right.a);
  // The elastica at 1.1 of Euler's load: amplitude 0.25 L (Timoshenko & Gere, table 2-4, interpolated), mean of a half
  // wave about 2/pi of it.
  CHECK(std::abs(w) == relative(0.25 * 10.0 * 2.0 / std::numbers::pi).epsilon(0.1));
  CHECK(opposite == relative(-w).epsilon(1e-4));
  CHECK(up.reports.back().newton.negative_pivots == 0);  // the buckled column is stable
}

TEST_CASE("a path that cannot go on says why") {
  ShallowArch arch;
  const petsc::VecHandle probe = probe_of(arch.model, "crown", 2);
  solve::StaticOptions options = arc(0.1, 0.1);
  options.max_steps = 3;
  const Record few = follow(arch.model, arch.a, options, probe);
  CHECK_FALSE(few.result.completed);
  CHECK(few.result.steps == 3);
  CHECK(few.result.reason == "max_steps = 3 steps did not reach the end of the path");
  ShallowArch again;
  const petsc::VecHandle other = probe_of(again.model, "crown", 2);
  options.max_steps = 100;
  options.min_step = 0.05;
  const Option iterations("-snes_max_it", "1");
  const Record stuck = follow(again.model, again.a, options, other);
  CHECK_FALSE(stuck.result.completed);
  CHECK(stuck.result.reason.find("no equilibrium found beyond load factor 0") == 0);
  CHECK(norm(again.a) == 0.0);
}

TEST_CASE("options of PETSc win over the case") {
  solve::StaticOptions options;
  const Option control("-path_control", "arc_length"), step("-path_initial_step", "0.125"),
      steps("-path_max_steps", "17"), critical("-path_at_critical_point", "stop");
  solve::read_path_options(PETSC_COMM_WORLD, options);
  CHECK(options.control == Control::arc_length);
  CHECK(options.initial_step == 0.125);
  CHECK(options.max_steps == 17);
  CHECK(options.at_critical_point == AtCriticalPoint::stop);
  const Option bad("-path_min_step", "0.5");
  CHECK_THROWS_AS(solve::read_path_options(PETSC_COMM_WORLD, options), UserError);
}

TEST_CASE("where a critical point lies is said as far as it is known") {
  using solve::CriticalPoint;
  CriticalPoint point{CriticalPoint::Kind::bifurcation, 3, 0.5};
  CHECK(solve::text_of(point) == "bifurcation point at load factor 0.5");
  point.between = {0.6, 0.4};
  CHECK(solve::text_of(point) == "bifurcation point between load factors 0.4 and 0.6");
  point.kind = CriticalPoint::Kind::both;
  CHECK(solve::text_of(point) == "limit point at load factor 0.5, bifurcation point between load factors 0.4 and 0.6");
}

}  // namespace test_path_following

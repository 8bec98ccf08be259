// Contact as a term of a distributed model: its tangent, the same contacts on any number of ranks, impact, moving
// obstacles.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "voile/base/error.hpp"
#include "voile/geometry/intersections.hpp"
#include "voile/solve/drape.hpp"
#include "voile/solve/time_integration.hpp"
#include "voile/system/contact.hpp"

using namespace voile;
using namespace voile::testing;
using contact::ContactSet;
using contact::Obstacle;
using SupportKind = system::Support::Kind;
using LoadKind = system::Load::Kind;

namespace {

/// Sheets of side 1 at heights k times `distance`, alternately shifted so that their vertices do not match.
mesh::MeshData sheets(int count, int cells, double distance) {
  mesh::MeshData all;
  all.source = "sheets";
  for (int k = 0; k < count; ++k) {
    const mesh::MeshData one = grid(cells, cells, k % 2 == 1, 0.1, 3u + static_cast<unsigned>(k));
    const auto first = static_cast<Index>(all.positions.size());
    for (const Vec3& x : one.positions) all.positions.emplace_back(x[0] + 0.03 * k, x[1] - 0.02 * k, distance * k);
    mesh::Group group{"sheet" + std::to_string(k), 2, {}, {}, {}};
    for (const mesh::Triangle& t : one.triangles) {
      group.triangles.push_back(static_cast<Index>(all.triangles.size()));
      all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    for (Index v = first; v < static_cast<Index>(all.positions.size()); ++v) group.vertices.push_back(v);
    all.groups.push_back(group);
  }
  return all;
}

Obstacle plane(double height, double friction = 0.0) {
  Obstacle o;
  o.name = "floor";
  o.shape = Obstacle::Shape::plane;
  o.points = {Vec3(0.0, 0.0, height)};
  o.friction = friction;
  return o;
}

Obstacle ball(const Vec3& centre, double radius) {
  Obstacle o;
  o.name = "ball";
  o.shape = Obstacle::Shape::sphere;
  o.points = {centre};
  o.radius = radius;
  return o;
}

system::ModelInput input(std::vector<Obstacle> obstacles, double distance) {
  system::ModelInput in;
  in.materials = {isotropic(1e5, 0.3, 1e-3, 0.3)};
  in.contact.active = true;
  in.contact.options = {distance, 1e4, 1e-3};
  in.contact.obstacles = std::move(obstacles);
  return in;
}

struct Problem {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle u, v;
  Problem(const mesh::MeshData& data, const system::ModelInput& in)
      : mesh(data),
        model(PETSC_COMM_WORLD, mesh, in),
        u(model.dofs().create_vector()),
        v(model.dofs().create_vector()) {}
};

/// Intersecting pairs of the sheet's triangles at a state. Collective.
std::size_t intersections(const system::Model& model, Vec u) {
  std::vector<Vec3> x = per_vertex(model, u);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += model.dofs().mesh().positions()[i];
  return geometry::intersecting_triangles(x, model.dofs().mesh().triangles()).size();
}

/// Integrates and counts intersections after every step.
Ended integrate(Problem& p, const system::DynamicsOptions& d, const solve::TimeOptions& o,
                const std::function<void(const system::State&, system::Dynamics&)>& look = {}) {
  system::Dynamics dynamics(p.model, d);
  solve::TimeIntegration time(dynamics, o);
  std::size_t found = 0;
  Ended r = follow_from(state_of(p.u, p.v), time, [&](const system::State& s, const solve::StepResult&) {
    found += intersections(p.model, s.u);
    CHECK(system::report(p.model.contact()->scene(), s.u).gap > 0.0);
    if (look) look(s, dynamics);
    return false;
  });
  CHECK(found == 0);
  return r;
}

}  // namespace

TEST_CASE("contact in a model: the tangent is the derivative of the residual, that of the energy") {
  system::ModelInput in = input({plane(-0.015), ball(Vec3(0.5, 0.5, 0.3), 0.25)}, 0.03);
  in.supports = {support("sheet0", SupportKind::displacement)};
  in.supports[0].components = {true, false, false};  // fixed rows and columns
  for (const auto membrane : {energy::MembraneOperator::six_node, energy::MembraneOperator::six_node_corrected}) {
    CAPTURE(static_cast<int>(membrane));
    in.element.membrane = membrane;
    Problem p(sheets(2, 6, 0.025), in);
    const int before = p.model.tangent().pattern_version();
    set_displacement(p.model, p.u, noise(2e-3, 1));
    p.model.conditions().enforce(p.u);
    petsc::VecHandle r = p.model.dofs().create_vector(), up = p.model.dofs().create_vector(),
                     down = p.model.dofs().create_vector(), w = p.model.dofs().create_vector(),
                     kw = p.model.dofs().create_vector(), x = p.model.dofs().create_vector();
    system::TangentRequest request;
    request.exact_contact = true;
    p.model.assemble_tangent(p.u, request);
    CHECK(p.model.tangent().pattern_version() == before + 1);
    set_displacement(p.model, w, noise(1.0, 2));
    p.model.dofs().clear_fixed(w);
    VOILE_PETSC(MatMult(p.model.tangent().matrix(), w, kw));
    const double h = 1e-8;
    VOILE_PETSC(VecWAXPY(x, h, w, p.u));
    p.model.residual(x, up);
    const double energy_up = p.model.energy(x);
    VOILE_PETSC(VecWAXPY(x, -h, w, p.u));
    p.model.residual(x, down);
    const double energy_down = p.model.energy(x);
    VOILE_PETSC(VecAXPY(up, -1.0, down));
    VOILE_PETSC(VecScale(up, 0.5 / h));
    p.model.dofs().clear_fixed(up);
    p.model.dofs().clear_fixed(kw);
    VOILE_PETSC(VecAXPY(up, -1.0, kw));
    CHECK(norm(up) < 1e-5 * norm(kw));
    p.model.residual(p.u, r);
    p.model.dofs().clear_fixed(r);
    CHECK((energy_up - energy_down) / (2.0 * h) == relative(dot(r, w)).epsilon(1e-6));
    // The constant bending stiffness was copied, not assembled, into the larger pattern.
    p.model.assemble_tangent(p.u, request);
    CHECK(p.model.tangent().pattern_version() == before + 1);
  }
}

TEST_CASE("contact in a model: pairs, energy and forces are those of one rank") {
  Problem p(sheets(3, 7, 0.025), input({ball(Vec3(0.5, 0.5, -0.29), 0.27)}, 0.03));
  set_displacement(p.model, p.u, noise(4e-3, 5));
  const contact::Surface& s = p.model.contact()->scene().set().surface();
  ContactSet alone(s, {}, {0.03, 1e4, 1e-3}, std::vector<char>(static_cast<std::size_t>(s.sheet_points), 1));
  const std::vector<Vec3> x = p.model.contact()->scene().positions(p.u);
  (void)alone.cover(x, x);
  const system::ContactReport report = system::report(p.model.contact()->scene(), p.u);
  const contact::ContactState state = alone.state(x);
  CHECK(report.pairs == state.pairs);
  CHECK(report.pairs > 100);
  CHECK(report.gap == state.gap);
  CHECK(p.model.contact()->energy(p.u) == relative(alone.energy(x)).epsilon(1e-12));
  petsc::VecHandle f = p.model.dofs().create_vector();
  p.model.contact()->add_gradient(p.u, f);
  const std::vector<Vec3> forces = per_vertex(p.model, f);
  std::vector<Vec3> wanted(forces.size(), Vec3::Zero());
  alone.add_gradient(x, wanted);
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    difference = std::max(difference, (forces[i] - wanted[i]).norm());
    size = std::max(size, wanted[i].norm());
  }
  CHECK(difference < 1e-12 * size);
}

TEST_CASE("pairs that come and go while sheets pass each other are those of one rank") {
  // Wide apart and close together in turns, a mesh as obstacle among them, so that ranks see others' points for a while.
  Obstacle table;
  table.name = "table";
  table.shape = Obstacle::Shape::mesh;
  table.points = {Vec3(-1.0, -1.0, -0.1), Vec3(3.0, -1.0, -0.1), Vec3(0.0, 3.0, -0.1)};
  table.triangles = {{0, 1, 2}};
  table.motion = [](const Vec3&, double t) { return Vec3(0.0, 0.0, 0.2 * t); };
  system::ModelInput in = input({table, ball(Vec3(0.3, 0.3, -0.4), 0.25)}, 0.03);
  in.contact.friction = 0.3;
  Problem p(sheets(4, 7, 0.025), in);
  system::Contact& contact = *p.model.contact();
  const contact::Surface& s = contact.scene().set().surface();
  const std::vector<char> all(static_cast<std::size_t>(s.sheet_points), 1);
  petsc::VecHandle f = p.model.dofs().create_vector(), way = p.model.dofs().create_vector();
  const Index sheet = p.mesh.vertex_count() / 4;
  const auto place = [&](unsigned k) {
    contact.set_time(0.1 * (k % 5));
    // In turns all move, and the last sheet alone is taken away: too few points to look at everything anew.
    const double slide = 0.3 * (k / 2 % 3), taken = k % 2 == 1 ? 0.3 : 0.0;
    set_displacement(p.model, p.u, [&](Index v) {
      const int layer = v / sheet;
      return Vec3(noise(4e-3, k / 2)(v) + layer * Vec3(slide, -0.5 * slide, 0.0) +
                  Vec3(0.0, 0.0, layer == 3 ? taken : 0.0));
    });
    return contact.scene().positions(p.u);
  };
  long pairs = 0;
  double shortest = 1.0;
  for (unsigned k = 0; k < 24; ++k) {
    CAPTURE(k);
    // Slips count from the start of the step, also for points that a rank sees only later.
    const std::vector<Vec3> start = place(k + 3);
    contact.start_step(p.u, 1e-3);
    const std::vector<Vec3> x = place(k);
    ContactSet alone(s, {}, {0.03, 1e4, 1e-3}, all);
    (void)alone.cover(x, x);
    const contact::ContactState state = alone.state(x);
    const system::ContactReport report = system::report(contact.scene(), p.u);
    CHECK(report.pairs == state.pairs);
    CHECK(report.gap == state.gap);
    pairs += state.pairs;
    contact.lag_friction(p.u);
    alone.lag_friction(x, start, 1e-3);
    CHECK(contact.energy(p.u) == relative(alone.energy(x)).epsilon(1e-12).scale(1.0));
    const std::vector<Vec3> later = place(k ^ 1u);  // the last sheet taken away, or put back
    (void)alone.cover(later, later);
    CHECK(system::report(contact.scene(), p.u).pairs == alone.state(later).pairs);
    place(k);
    set_displacement(p.model, way, noise(0.02, 100 + k));
    const std::vector<Vec3> ways = per_vertex(p.model, way);
    std::vector<Vec3> to = x;
    for (std::size_t i = 0; i < ways.size(); ++i) to[i] += ways[i];
    (void)alone.cover(x, to);
    const double fraction = contact.step_fraction(p.u, way);
    CHECK(fraction == relative(alone.step_fraction(x, to)).epsilon(1e-9));
    shortest = std::min(shortest, fraction);
    VOILE_PETSC(VecAXPY(p.u, 0.5 * fraction, way));
    const std::vector<Vec3> now = contact.scene().positions(p.u);
    alone.lag_friction(now, start, 1e-3);
    contact.lag_friction(p.u);
    VOILE_PETSC(VecZeroEntries(f));
    contact.add_gradient(p.u, f);
    std::vector<Vec3> wanted(ways.size(), Vec3::Zero());
    alone.add_gradient(now, wanted);
    const std::vector<Vec3> forces = per_vertex(p.model, f);
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < forces.size(); ++i) {
      difference = std::max(difference, (forces[i] - wanted[i]).norm());
      size = std::max(size, wanted[i].norm());
    }
    CHECK(difference <= 1e-9 * size);
  }
  CHECK(pairs > 1000);
  CHECK(shortest < 0.5);
}

TEST_CASE("free impact of two sheets without friction: momentum stays, nothing intersects") {
  Problem p(sheets(2, 6, 0.05), input({}, 0.02));
  set_displacement(p.model, p.v, [&](Index v) { return Vec3(0.2, 0.0, v < p.mesh.vertex_count() / 2 ? 1.0 : -1.5); });
  Vec3 first = Vec3::Zero();
  double drift = 0.0;
  long most = 0;
  const Option rtol("-snes_rtol", "1e-10");
  const Ended r = integrate(p, {}, motion_options(0.06, 2e-3), [&](const system::State& state, system::Dynamics& d) {
    const Vec3 momentum = d.momentum(state.v);
    if (state.step == 0) first = momentum;
    drift = std::max(drift, (momentum - first).norm());
    most = std::max(most, system::report(p.model.contact()->scene(), state.u).pairs);
  });
  CHECK(r.completed);
  CHECK(most > 50);
  CHECK(drift < 1e-8 * 0.3);
}

TEST_CASE("a sheet comes to rest on a floor that then carries its weight") {
  system::ModelInput in = input({plane(-0.015)}, 0.02);
  in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))};
  in.supports = {support("sheet0", SupportKind::displacement)};
  in.supports[0].components = {true, true, false};
  Problem p(sheets(1, 6, 0.0), in);
  p.model.conditions().set_load_factor(1.0);
  solve::Drape drape(p.model, {});
  CHECK(follow_from(state_of(p.u), drape).completed);
  CHECK(drape.stability().stable);
  petsc::VecHandle f = p.model.dofs().create_vector();
  p.model.contact()->add_gradient(p.u, f);
  Vec3 total = Vec3::Zero();
  for (const Vec3& v : per_vertex(p.model, f)) total -= v;
  CHECK(total[2] == relative(0.3 * 9.81).epsilon(1e-6));
}

TEST_CASE("draping has no time: what moves with the time stands still while a sheet falls") {
  Obstacle lift = plane(-0.1);
  lift.motion = [](const Vec3&, double t) { return Vec3(0.0, 0.0, -20.0 * (t - 0.5)); };
  system::ModelInput in = input({lift}, 0.02);
  in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))};
  in.supports = {support("sheet0", SupportKind::displacement)};
  in.supports[0].components = {true, true, false};
  Problem p(sheets(1, 6, 0.0), in);
  p.model.conditions().set_load_factor(1.0);
  p.model.set_time(0.5);
  solve::Drape drape(p.model, {});
  system::State state = state_of(p.u);
  state.time = 0.5;
  CHECK(follow_from(std::move(state), drape).completed);
  for (const Vec3& u : per_vertex(p.model, p.u)) {
    CHECK(u[2] < -0.07);
    CHECK(u[2] > -0.1);
  }
  CHECK(p.model.contact()->scene().time() == 0.5);
}

TEST_CASE("an obstacle that rushes through a resting sheet takes it along") {
  Obstacle piston = plane(-0.03);
  piston.motion = [](const Vec3&, double t) { return Vec3(0.0, 0.0, 20.0 * t); };
  Problem p(sheets(1, 6, 0.0), input({piston}, 0.02));
  const Ended r = integrate(p, {}, motion_options(0.05, 0.01));
  CHECK(r.completed);
  double lowest = 1e9;
  for (const Vec3& u : per_vertex(p.model, p.u)) lowest = std::min(lowest, u[2]);
  CHECK(lowest > 20.0 * 0.05 - 0.03);  // above the plane, which is there now
}

TEST_CASE("a ball shot at a sheet does not pass through it") {
  Obstacle shot = ball(Vec3(0.5, 0.5, -0.4), 0.1);
  shot.motion = [](const Vec3&, double t) { return Vec3(0.0, 0.0, 40.0 * t); };
  Problem p(sheets(1, 8, 0.0), input({shot}, 0.02));
  const Ended r = integrate(p, {}, motion_options(0.02, 0.005));
  CHECK(r.completed);
  // The middle is still before the ball.
  double middle = -1e9;
  const std::vector<Vec3> u = per_vertex(p.model, p.u);
  for (std::size_t v = 0; v < u.size(); ++v)
    if ((p.mesh.positions()[v] - Vec3(0.5, 0.5, 0.0)).norm() < 0.1) middle = std::max(middle, u[v][2]);
  CHECK(middle > -0.4 + 40.0 * 0.02 + 0.1);
}

TEST_CASE("what cannot be avoided ends the run and is named") {
  Obstacle above = plane(0.03);
  above.normal = -Vec3::UnitZ();
  above.name = "press";
  above.motion = [](const Vec3&, double t) { return Vec3(0.0, 0.0, -t); };
  Problem p(sheets(1, 4, 0.0), input({plane(-0.03), above}, 0.02));
  solve::TimeOptions o = motion_options(0.1, 0.01);
  o.min_step = 1e-3;
  const Ended r = integrate(p, {}, o);
  CHECK(!r.completed);
  CHECK(r.state.time < 0.06);
  CHECK(r.reason.find("in the way was sheet against ") != std::string::npos);
}

/// Static residual of the start, free components only.
petsc::VecHandle residual(Problem& p) {
  petsc::VecHandle r = p.model.dofs().create_vector();
  p.model.conditions().set_load_factor(1.0);
  p.model.residual(p.u, r);
  p.model.dofs().clear_fixed(r);
  return r;
}

TEST_CASE("a way through something that is held is no way") {
  for (const bool held : {true, false}) {
    system::ModelInput in = input({plane(-0.03)}, 0.02);
    in.contact.obstacles[0].motion = [](const Vec3&, double t) { return Vec3(0.0, 0.0, t); };
    if (held) in.supports = {support("sheet0", SupportKind::hinged)};
    Problem p(sheets(1, 4, 0.0), in);
    petsc::VecHandle to = p.model.dofs().create_vector();
    const system::Contact::Clearance way = p.model.contact()->clear_predictor(p.u, 0.0, to, 0.06);
    CAPTURE(way.obstruction);
    CHECK(way.clear == !held);
    CHECK((norm(to) > 0.0) == !held);
    CHECK((way.obstruction.find("floor") != std::string::npos) == held);
  }
}

TEST_CASE("a sheet that turns with what it lies on does not slip, whatever the angle at the start") {
  const double d = 0.01, speed = 2.0;  // rad/s about an axis off the sheet
  const Vec3 centre(0.3, -0.4, 0.0);
  const auto turned = [&](const Vec3& x, double t) {
    return Vec3(Eigen::AngleAxisd(speed * t, Vec3::UnitZ()) * (x - centre) + centre);
  };
  Obstacle table = plane(-0.7 * d, 0.5);
  table.motion = [&](const Vec3& x, double t) { return Vec3(turned(x, t) - x); };
  Problem p(sheets(1, 4, 0.0), input({table}, d));
  system::Contact& contact = *p.model.contact();
  const auto forces_after = [&](double start, double dt) {
    petsc::VecHandle now = p.model.dofs().create_vector(), f = p.model.dofs().create_vector();
    const auto& x = p.mesh.positions();
    set_displacement(p.model, now, [&](Index v) { return Vec3(turned(x[v], start) - x[v]); });
    contact.set_time(start);
    contact.start_step(now, 1e-4);
    set_displacement(p.model, now, [&](Index v) { return Vec3(turned(x[v], start + dt) - x[v]); });
    contact.set_time(start + dt);
    contact.add_gradient(now, f, ContactSet::friction);
    return norm(f);
  };
  petsc::VecHandle pressed = p.model.dofs().create_vector();
  contact.add_gradient(p.u, pressed, ContactSet::normal);
  for (const double start : {0.0, 0.4, 1.3}) {
    CAPTURE(start);
    CHECK(forces_after(start, 0.01) < 1e-8 * norm(pressed));
  }
}

TEST_CASE("the positive tangent takes friction's secant where slips have grown") {
  const double d = 0.01, friction = 0.4, slip = 1e-4, moved = 20.0 * slip;
  Problem p(sheets(1, 4, 0.0), input({plane(-0.7 * d, friction)}, d));
  system::Contact& contact = *p.model.contact();
  petsc::VecHandle pressed = p.model.dofs().create_vector(), a = p.model.dofs().create_vector(),
                   along = p.model.dofs().create_vector(), k = p.model.dofs().create_vector();
  contact.add_gradient(p.u, pressed, ContactSet::normal);
  double normal = 0.0;
  VOILE_PETSC(VecSum(pressed, &normal));
  set_displacement(p.model, along, [](Index) { return Vec3(Vec3::UnitX()); });
  const auto stiffness = [&](double displacement) {  // against a translation along the slip; the sheet itself has none
    VOILE_PETSC(VecCopy(along, a));
    VOILE_PETSC(VecScale(a, displacement));
    p.model.assemble_tangent(a, {.kind = energy::Tangent::positive});
    VOILE_PETSC(MatMult(p.model.tangent().matrix(), along, k));
    return dot(along, k);
  };
  contact.start_step(p.u, slip);
  (void)stiffness(0.0);  // the first tangent of a step trusts the first guess
  CHECK(stiffness(moved) == relative(friction * std::abs(normal) / moved).epsilon(1e-6));
  CHECK(std::abs(stiffness(1.2 * moved)) < 1e-3 * friction * std::abs(normal) / moved);  // no longer growing much
}

TEST_CASE("a start inside the contact distance is let out gently") {
  const double d = 0.01, settle_time = 0.1, mass = 0.3;
  for (const int count : {1, 2, 5})  // of five, the inner ones are balanced at first
    for (const double share : {0.99, 0.5, 0.3})
      for (const double step : {1e-3, 1e-2, 4e-2}) {
        CAPTURE(count);
        CAPTURE(share);
        CAPTURE(step);
        system::ModelInput in =
            input(count == 1 ? std::vector<Obstacle>{plane(-share * d)} : std::vector<Obstacle>{}, d);
        in.contact.options.settle_time = settle_time;
        Problem p(sheets(count, 6, share * d), in);
        const double barrier = p.model.contact()->energy(p.u);
        p.model.contact()->begin_settling(p.u, residual(p), 0.0);
        CHECK(p.model.contact()->energy(p.u) == 0.0);
        double kinetic = 0.0, gap = 0.0;
        const Ended r = integrate(p, {}, motion_options(step < 0.01 ? 0.02 : 0.2, step),
                                  [&](const system::State& state, system::Dynamics& dynamics) {
                                    kinetic = std::max(kinetic, dynamics.kinetic_energy(state.v));
                                    gap = system::report(p.model.contact()->scene(), state.u).gap;
                                  });
        CHECK(r.completed);
        const double speed = (1.0 - share) * d / settle_time;
        CHECK(kinetic > 0.0);
        CHECK(kinetic < barrier);
        // The layers of five move by 2, 1, 0, 1, 2 of these.
        CHECK(kinetic < (count < 5 ? 1.0 : 10.0) * 0.5 * mass * std::pow(3.0 * speed, 2));
        if (step >= 0.01) CHECK(gap > 0.98 * d);
      }
}

TEST_CASE("a start that rests on its contact keeps it") {
  const double d = 0.01, mass = 0.3;
  system::ModelInput in = input({plane(-0.5 * d)}, d);
  Problem probe(sheets(1, 6, 0.0), in);
  const petsc::VecHandle push = residual(probe);  // nothing but contact: what it takes to balance it
  double total = 0.0;
  VOILE_PETSC(VecSum(push, &total));
  for (const double share : {1.0, 0.6, 0.4}) {
    CAPTURE(share);
    in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, share * total / mass))};
    Problem p(sheets(1, 6, 0.0), in);
    const double whole = p.model.contact()->energy(p.u);
    p.model.contact()->begin_settling(p.u, residual(p), 0.0);
    CHECK(p.model.contact()->energy(p.u) == (share > 0.5 ? whole : 0.0));
  }
}

TEST_CASE("what is being let out goes on where it was") {
  const double d = 0.01;
  Problem p(sheets(2, 6, 0.5 * d), input({}, d)), q(sheets(2, 6, 0.5 * d), input({}, d));
  p.model.contact()->begin_settling(p.u, residual(p), 1.0);
  CHECK(p.model.contact()->memory().gaps.size() == static_cast<std::size_t>(p.mesh.vertex_count()));
  q.model.contact()->restore(p.model.contact()->memory());
  for (const double t : {1.02, 1.05, 1.2}) {
    p.model.contact()->set_time(t);
    q.model.contact()->set_time(t);
    CHECK(p.model.contact()->energy(p.u) > 0.0);
    CHECK(p.model.contact()->energy(p.u) == q.model.contact()->energy(q.u));
  }
  Problem whole(sheets(2, 6, 0.5 * d), input({}, d));
  CHECK(whole.model.contact()->energy(whole.u) == p.model.contact()->energy(p.u));
}

/// A sheet with slivers: one vertex of a grid lies 2 % of a cell beside an edge.
mesh::MeshData with_sliver(int count, double distance) {
  mesh::MeshData all = sheets(count, 6, distance);
  const mesh::Triangle t = all.triangles[30];
  const Vec3 a = all.positions[t[0]], b = all.positions[t[1]], c = all.positions[t[2]];
  const Vec3 foot = a + (c - a).dot(b - a) / (b - a).squaredNorm() * (b - a);
  all.positions[t[2]] = foot + 0.02 * (c - foot);
  return all;
}

TEST_CASE("slivers: neighbours nearer than the contact distance are at rest, and other sheets are still felt") {
  const double d = 0.02;
  Problem one(with_sliver(1, 0.0), input({}, d));
  CHECK(one.model.contact()->scene().input().notes.size() == 1);
  CHECK(one.model.contact()->scene().input().notes[0].find("less high") != std::string::npos);
  CHECK(one.model.contact()->energy(one.u) == 0.0);
  CHECK(!one.model.contact()->scene().set().surface().neighbours.of_faces.empty());
  for (const auto& [points, share] : one.model.contact()->scene().set().surface().neighbours.of_edges)
    CHECK((share > 0.0 && share < 1.0));
  // Crushed to a third of its width the sliver is felt.
  set_displacement(one.model, one.u, [&](Index v) {
    const mesh::Triangle& t = one.mesh.triangles()[30];
    if (v != t[2]) return Vec3(Vec3::Zero());
    const Vec3 &a = one.mesh.positions()[t[0]], &b = one.mesh.positions()[t[1]], &c = one.mesh.positions()[t[2]];
    const Vec3 foot = a + (c - a).dot(b - a) / (b - a).squaredNorm() * (b - a);
    return Vec3(0.67 * (foot - c));
  });
  CHECK(one.model.contact()->energy(one.u) > 0.0);
  // Two layers one above the other are no neighbours, slivers or not.
  Problem with(with_sliver(2, 0.5 * d), input({}, d)), without(sheets(2, 6, 0.5 * d), input({}, d));
  const double e = with.model.contact()->energy(with.u), whole = without.model.contact()->energy(without.u);
  CHECK(e == relative(whole).epsilon(0.1));
}

TEST_CASE("an obstacle that yields gives way to what it pinches, until that is free again") {
  const auto run = [](bool yields, Obstacle above, const Obstacle& below) {
    above.name = "press";
    above.yields = yields;
    system::ModelInput in = input({below, above}, 0.01);
    in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))};
    Problem p(sheets(1, 8, 0.0), in);
    long most = 0, last = 0;
    solve::TimeOptions o = motion_options(0.3, 0.01);
    o.velocity_tolerance = 1e-3;
    const Ended r = integrate(p, {}, o, [&](const system::State&, system::Dynamics&) {
      last = system::yielding_count(p.model.contact()->memory());
      most = std::max(most, last);
      if (last == 0) return;
      Problem q(sheets(1, 8, 0.0), input({below, above}, 0.01));
      q.model.contact()->restore(p.model.contact()->memory());
      CHECK(system::yielding_count(q.model.contact()->memory()) == last);
    });
    double lowest = 1e9;
    for (const Vec3& u : per_vertex(p.model, p.u)) lowest = std::min(lowest, u[2]);
    CHECK(r.completed == yields);
    CHECK((most > 0) == yields);
    CHECK(last == 0);
    return lowest;
  };
  const auto motion = [](double sign, double depth) {
    return [=](const Vec3&, double t) { return Vec3(0.0, 0.0, -sign * depth * std::sin(t * std::numbers::pi / 0.2)); };
  };
  Obstacle press = plane(0.03);
  press.normal = -Vec3::UnitZ();
  press.motion = motion(1.0, 0.08);
  for (const bool yields : {false, true}) CHECK(run(yields, press, plane(-0.03)) > -0.03);
  Obstacle upper = ball(Vec3(0.5, 0.5, 0.34), 0.3), lower = ball(Vec3(0.5, 0.5, -0.34), 0.3);
  upper.motion = motion(1.0, 0.06);
  lower.motion = motion(-1.0, 0.06);
  lower.name = "lower";
  for (const bool yields : {false, true}) (void)run(yields, upper, lower);
}

TEST_CASE("a rule for a curve holds for its vertices and what touches them") {
  mesh::MeshData d = grid(6, 6, true, 0.1, 7);
  add_square_groups(d);
  const mesh::SurfaceMesh mesh(d);
  std::vector<int> curve(static_cast<std::size_t>(mesh.vertex_count()), -1);
  for (Index v : mesh.group("left").vertices) curve[static_cast<std::size_t>(v)] = 1;
  for (Index v : mesh.group("bottom").vertices) curve[static_cast<std::size_t>(v)] = 2;  // a corner belongs to the last
  const contact::Surface s = contact::make_surface(mesh, {{"sheet", 0.0}, {"left", 0.0}, {"bottom", 0.0}}, {}, curve);
  const auto on = [&](Index v, int axis) { return mesh.positions()[v][axis] < 1e-9; };
  const auto expected = [&](const auto& points) {
    int body = 0;
    for (Index v : points) body = std::max(body, on(v, 1) ? 2 : on(v, 0) ? 1 : 0);
    return body;
  };
  for (Index v = 0; v < s.sheet_points; ++v) CHECK(s.body_of_point[v] == expected(std::array{v}));
  for (const contact::Edge& e : s.edges) CHECK(e.body == expected(e.points));
  for (const contact::Face& f : s.faces) CHECK(f.body == expected(f.points));
}

TEST_CASE("a hem that ignores an obstacle lets it through, the rest of the sheet does not") {
  // A spike rises through the left edge: between vertices, at one, or under the second row, which still sees it.
  mesh::MeshData d = grid(8, 8, true, 0.0);
  add_square_groups(d);
  const auto spike = [](double x, double y) {
    Obstacle o;
    o.name = "spike";
    o.points = {{x - 0.02, y - 0.02, -0.5}, {x + 0.02, y - 0.02, -0.5}, {x, y + 0.03, -0.5}, {x, y, -0.04}};
    o.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    o.motion = [](const Vec3&, double t) { return Vec3(0.0, 0.0, 2.0 * t); };
    return o;
  };
  struct Trial {
    double x, y;
    bool ignore, passes;
  };
  for (const Trial& trial : {Trial{0.0, 0.5, false, false},
                             {0.0, 0.5, true, true},
                             {0.03, 0.55, true, true},
                             {0.25, 0.5, true, false},
                             {0.18, 0.5, true, false}}) {
    CAPTURE(trial.x);
    CAPTURE(trial.ignore);
    system::ModelInput in = input({spike(trial.x, trial.y)}, 0.01);
    in.contact.rules = {{"left", "spike", {}, trial.ignore}};
    const mesh::SurfaceMesh mesh(d);
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    petsc::VecHandle u = model.dofs().create_vector(), v = model.dofs().create_vector();
    system::Dynamics dynamics(model, {});
    solve::TimeIntegration time(dynamics, motion_options(0.06, 0.005));
    REQUIRE(follow_from(state_of(u, v), time).completed);
    double lifted = 0.0;
    for (const Vec3& w : per_vertex(model, u)) lifted = std::max(lifted, w[2]);
    if (trial.passes)
      CHECK(lifted < 1e-9);
    else
      CHECK(lifted > 0.06);  // the tip rises from 4 cm below to 8 cm above
  }
}

TEST_CASE("a hem with friction of its own is taken along, where the sheet slips") {
  // A sheet lies on a floor that moves: only its leading hem has friction. The vertices of the hem carry their areas'
  // share of the weight, an eighth, and slip: the momentum of the sheet grows by mu N t. It starts where it rests: with
  // the gap g = d (1 - z), kappa |b'| = 3 kappa z^2 (1 + ...) carries 2.943 Pa at z = 0.0099.
  mesh::MeshData d = grid(4, 4, true, 0.0);
  add_square_groups(d);
  Obstacle floor = plane(-0.009901);
  floor.motion = [](const Vec3&, double t) { return Vec3(t, 0.0, 0.0); };
  const auto momentum = [&](std::optional<double> friction) {
    system::ModelInput in = input({floor}, 0.01);
    in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))};
    in.contact.rules = {{"floor", "right", friction, false}};
    const mesh::SurfaceMesh mesh(d);
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    petsc::VecHandle u = model.dofs().create_vector(), v = model.dofs().create_vector();
    system::Dynamics dynamics(model, {});
    solve::TimeIntegration time(dynamics, motion_options(0.1, 0.005));
    REQUIRE(follow_from(state_of(u, v), time).completed);
    return dynamics.momentum(v)[0];
  };
  CHECK(std::abs(momentum(std::nullopt)) < 1e-9);
  // At the very start friction knows no slip yet: half of the first step is without it.
  CHECK(momentum(0.5) == relative(0.5 * 0.3 * 9.81 / 8.0 * (0.1 - 0.5 * 0.005)).epsilon(2e-3));
}

TEST_CASE("contact refuses a distance too large for the mesh and unknown names") {
  const auto message = [](system::ModelInput in) -> std::string {
    try {
      Problem p(sheets(1, 6, 0.0), in);
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  };
  CHECK(message(input({}, 0.2)).find("too much for this mesh") != std::string::npos);
  system::ModelInput in = input({plane(-1.0)}, 0.01);
  in.contact.rules = {{"floor", "celling", {}, true}};
  CHECK(message(in).find("'celling'; correct the name") != std::string::npos);
}

TEST_CASE("the energy of two parallel sheets hardly depends on their meshes") {
  // Half of kappa b(g) per area comes from the points of each side, the rest from edges that cross.
  const double gap = 0.01, distance = 0.02, exact = 1e4 * contact::barrier(gap, distance).value;
  double least = 1e9, most = 0.0;
  for (const int cells : {6, 9, 14}) {
    Problem p(sheets(2, cells, gap), input({}, distance));
    const double ratio = p.model.contact()->energy(p.u) / (0.97 * 0.98 * exact);
    least = std::min(least, ratio);
    most = std::max(most, ratio);
  }
  CHECK(least > 2.0);
  CHECK(most < 3.0);
  CHECK(most < 1.1 * least);
}

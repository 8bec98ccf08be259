// Rules of contact, passable obstacles, slivers, and what is refused.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "solve/time_integration.hpp"
#include "system/contact.hpp"
#include "test_contact_model_kit.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_contact_rules {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::contacts;

namespace {

/// A sheet with slivers: one vertex of a grid lies 2 % of a cell beside an edge.
mesh::MeshData with_sliver(int count, double distance) {
  mesh::MeshData all = sheets(count, 6, distance);
  const mesh::Triangle t = all.triangles[30];
  const Vec3 a = all.positions[t[0]], b = all.positions[t[1]], c = all.positions[t[2]];
  const Vec3 foot = a + (c - a).dot(b - a) / (b - a).squaredNorm() * (b - a);
  all.positions[t[2]] = foot + 0.02 * (c - foot);
  return all;
}

}  // namespace

TEST_CASE("slivers: neighbours nearer than the activation distance are at rest, and other sheets are still felt") {
  const double d = 0.02;
  Problem one(with_sliver(1, 0.0), input({}, d));
  CHECK(one.model.contact()->scene().input().notes.size() == 1);
  CHECK(one.model.contact()->scene().input().notes[0].find("less high") != std::string::npos);
  CHECK(one.model.contact()->energy(one.u) == 0.0);
  CHECK(!one.model.contact()->scene().set().surface().neighbours.of_faces.empty());
  for (const auto& [points, fraction] : one.model.contact()->scene().set().surface().neighbours.of_edges)
    CHECK((fraction > 0.0 && fraction < 1.0));
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

TEST_CASE("cloth passes through a passable obstacle that pinches it, until it is free again") {
  const auto run = [](bool passable, Obstacle above, const Obstacle& below) {
    above.name = "press";
    above.passable = passable;
    system::ModelInput in = input({below, above}, 0.01);
    in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))};
    Problem p(sheets(1, 8, 0.0), in);
    long most = 0, last = 0;
    solve::TimeOptions o = motion_options(0.3, 0.01);
    o.velocity_tolerance = 1e-3;
    const Ended r = integrate(p, {}, o, [&](const system::State&, system::Dynamics&) {
      last = system::passing_count(p.model.contact()->memory());
      most = std::max(most, last);
      if (last == 0) return;
      Problem q(sheets(1, 8, 0.0), input({below, above}, 0.01));
      q.model.contact()->restore(p.model.contact()->memory());
      CHECK(system::passing_count(q.model.contact()->memory()) == last);
    });
    double lowest = 1e9;
    for (const Vec3& u : per_vertex(p.model, p.u)) lowest = std::min(lowest, u[2]);
    CHECK(r.completed == passable);
    CHECK((most > 0) == passable);
    CHECK(last == 0);
    return lowest;
  };
  const auto motion = [](double sign, double depth) {
    return [=](const Vec3&, double t) { return Vec3(0.0, 0.0, -sign * depth * std::sin(t * std::numbers::pi / 0.2)); };
  };
  Obstacle press = plane(0.03);
  press.normal = -Vec3::UnitZ();
  press.motion = motion(1.0, 0.08);
  for (const bool passable : {false, true}) CHECK(run(passable, press, plane(-0.03)) > -0.03);
  Obstacle upper = ball(Vec3(0.5, 0.5, 0.34), 0.3), lower = ball(Vec3(0.5, 0.5, -0.34), 0.3);
  upper.motion = motion(1.0, 0.06);
  lower.motion = motion(-1.0, 0.06);
  lower.name = "lower";
  for (const bool passable : {false, true}) (void)run(passable, upper, lower);
}

TEST_CASE("without rules every pair of bodies has the friction of its obstacle, sheets that of themselves") {
  std::vector<Obstacle> obstacles{ball(Vec3(0.0, 0.0, -1.0), 0.25), ball(Vec3(0.0, 0.0, -2.0), 0.25)};
  obstacles[0].friction = 0.5;
  obstacles[1].friction = 0.7;
  obstacles[1].name = "other";
  system::ModelInput in = input(obstacles, 0.01);
  in.contact.self = false;
  in.contact.friction = 0.2;
  const Problem p(sheets(1, 3, 0.05), in);
  const auto& rules = p.model.contact()->scene().set().surface().rules;
  const std::array<std::array<double, 3>, 3> friction{{{0.2, 0.5, 0.7}, {0.5, -1.0, -1.0}, {0.7, -1.0, -1.0}}};
  REQUIRE(rules.size() == 3);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      CAPTURE(i);
      CAPTURE(j);
      CHECK(rules[i][j].touch == ((i == 0) != (j == 0)));
      if (rules[i][j].touch || i + j == 0) CHECK(rules[i][j].friction == friction[i][j]);
    }
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
  // fraction of the weight, an eighth, and slip: the momentum of the sheet grows by mu N t. It starts where it rests: with
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

}  // namespace test_contact_rules

// Contact in motion: impact, moving obstacles, starts within the activation distance.
#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "extent.hpp"
#include "solve/drape.hpp"
#include "solve/time_integration.hpp"
#include "system/contact.hpp"
#include "test_contact_model_kit.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"

namespace test_contact_motion {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::contacts;

TEST_CASE("free impact of two sheets without friction: momentum stays, nothing intersects") {
  for (const auto& element :
       {std::pair{energy::MembraneOperator::six_node, energy::BendingOperator::edge_slope},
        std::pair{energy::MembraneOperator::six_node_corrected, energy::BendingOperator::edge_slope},
        std::pair{energy::MembraneOperator::six_node_corrected, energy::BendingOperator::edge_angle}}) {
    CAPTURE(static_cast<int>(element.first));
    CAPTURE(static_cast<int>(element.second));
    system::ModelInput in = input({}, 0.02);
    in.element.membrane = element.first;
    in.element.bending = element.second;
    Problem p(sheets(2, 6, 0.05), in);
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

TEST_CASE("a start inside the activation distance is let out gently") {
  const double d = 0.01, settle_time = 0.1, mass = 0.3;
  for (const int count : {1, 2, 5})  // of five, the inner ones are balanced at first
    for (const double fraction : {0.99, 0.5, 0.3})
      for (const double step : {1e-3, 1e-2, 4e-2}) {
        if (extent(false, fraction != 0.5 || step < 0.01)) continue;
        CAPTURE(count);
        CAPTURE(fraction);
        CAPTURE(step);
        system::ModelInput in =
            input(count == 1 ? std::vector<Obstacle>{plane(-fraction * d)} : std::vector<Obstacle>{}, d);
        in.contact.options.settle_time = settle_time;
        Problem p(sheets(count, 6, fraction * d), in);
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
        const double speed = (1.0 - fraction) * d / settle_time;
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
  for (const double fraction : {1.0, 0.6, 0.4}) {
    CAPTURE(fraction);
    in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, fraction * total / mass))};
    Problem p(sheets(1, 6, 0.0), in);
    const double whole = p.model.contact()->energy(p.u);
    p.model.contact()->begin_settling(p.u, residual(p), 0.0);
    CHECK(p.model.contact()->energy(p.u) == (fraction > 0.5 ? whole : 0.0));
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

}  // namespace test_contact_motion

// Saved states, and what comes from outside between steps.
#include <petscksp.h>

#include "test_strip.hpp"

namespace voile::test_coupling {

using namespace testing;

TEST_CASE("a saved state is gone back to, on one rank bit by bit") {
  for (const bool contact : {false, true}) {
    CAPTURE(contact);
    Case c = contact ? ball_below() : strip("dynamic");
    c.set("time.end", 0.2);
    if (contact) c.set("load.0.vector", {0, 0, -4}).set("contact.friction", 0.3);
    Simulation s(PETSC_COMM_WORLD, c);
    if (contact) s.set_obstacle("ball", {0.7, 0.125, -0.09}, 0.15);
    CHECK(s.advance_to(0.1));
    const State saved = s.save();
    const std::vector<double> before = s.positions();
    const Energy energy = s.energy();
    CHECK(saved.time() == 0.1);
    CHECK((energy.contact > 0.0) == contact);
    CHECK(s.run());
    const std::vector<double> x = s.positions(), v = s.velocities();
    const std::size_t rows = s.history().rows.size();
    for (int k = 0; k < 2; ++k) {
      if (contact) {  // it is gone back to where it was going, too
        s.restore(saved);
        s.set_obstacle("ball", {0.8, 0.125, -0.5}, 0.15);
        CHECK(s.run());
        CHECK(s.obstacle("ball")[2] == -0.5);
      }
      s.restore(saved);
      CHECK(same(s.positions(), before));
      CHECK(!s.finished());
      CHECK(s.energy().membrane == doctest::Approx(energy.membrane));
      CHECK(s.run());
      CHECK(difference(s.positions(), x) <= (is_alone() ? 0.0 : 1e-9));
      CHECK(difference(s.velocities(), v) <= (is_alone() ? 0.0 : 1e-7));
      CHECK(s.history().rows.size() == rows);
    }
  }
}

TEST_CASE("a state is gone back to in the middle of an impact") {
  Case c = ball_below();
  c.set("time.end", 0.1).set("load.0.vector", {0, 0, -0.4});
  Simulation s(PETSC_COMM_WORLD, c);
  s.set_obstacle("ball", {0.8, 0.125, 0.0}, 0.1);
  while (s.energy().contact == 0.0) REQUIRE(s.advance().accepted);
  const State saved = s.save();
  CHECK(s.run());
  const std::vector<double> x = s.positions();
  s.restore(saved);
  CHECK(s.run());
  CHECK(difference(s.positions(), x) <= (is_alone() ? 0.0 : 1e-9));
}

TEST_CASE("a path is gone back on, too") {
  Case c = strip("static");
  c.set("load.0.vector", {0, 0, 4.0}).set("steps.initial_step", 0.25);
  Simulation s(PETSC_COMM_WORLD, c);
  CHECK(s.advance().accepted);
  const State saved = s.save();
  CHECK(s.run());
  const std::vector<double> x = s.positions();
  s.restore(saved);
  CHECK(s.load_factor() == 0.25);
  CHECK(s.run());
  CHECK(difference(s.positions(), x) <= (is_alone() ? 0.0 : 1e-8));
}

TEST_CASE("forces from outside act as loads of the case do, and are part of the balance of energy") {
  Case loaded = strip("dynamic"), bare = strip("dynamic");
  bare.set("load.0.vector", {0, 0, 0});
  Simulation a(PETSC_COMM_WORLD, loaded), b(PETSC_COMM_WORLD, bare);
  std::vector<double> f(3 * static_cast<std::size_t>(b.vertex_count()), 0.0);
  for (const int v : b.group("tip")) {  // half of what the ends of a cell of 0.125 m get falls on the corners
    const double y = b.positions()[3 * static_cast<std::size_t>(v) + 1];
    f[3 * static_cast<std::size_t>(v) + 2] = 0.4 * 0.125 * (y > 0.01 && y < 0.24 ? 1.0 : 0.5);
  }
  b.set_forces(f);
  CHECK(a.run());
  CHECK(b.run());
  CHECK(difference(a.positions(), b.positions()) < 1e-9);
  const Energy e = b.energy();
  CHECK(e.loads == doctest::Approx(a.energy().loads));
  CHECK(e.external == doctest::Approx(a.energy().external));
  CHECK(std::abs(e.unaccounted) < 1e-6 * e.loads);
  CHECK_THROWS_AS(b.set_forces({1.0, 2.0}), UserError);
  f[4] = std::nan("");
  CHECK_THROWS_AS(b.set_forces(f), UserError);
}

TEST_CASE("forces change between steps, and go away") {
  Case c = strip("dynamic");
  c.set("load.0.vector", {0, 0, 0});
  Simulation s(PETSC_COMM_WORLD, c);
  s.set_forces(tip_forces(s, 0.1));
  s.advance();
  const double up = tip_height(s);
  CHECK(up > 0.0);
  CHECK(s.energy().loads == doctest::Approx(-s.energy().external));
  s.set_forces({});
  CHECK(s.energy().external == 0.0);
  const double work = s.energy().loads;
  s.advance();
  CHECK(s.energy().loads == work);
}

TEST_CASE("forces from outside on a rigid group go away, too") {
  Case c = Case::parse(strip("dynamic").source() + "[[rigid]]\ngroup = \"tip\"\nmass = 0.1\n");
  c.set("load.0.vector", {0, 0, 0});
  Simulation s(PETSC_COMM_WORLD, c);
  s.set_forces(tip_forces(s, 0.1));
  s.advance();
  const double work = s.energy().loads;
  CHECK(work > 0.0);
  s.set_forces({});
  s.advance();
  CHECK(s.energy().loads == doctest::Approx(work).epsilon(1e-12));
}

TEST_CASE("an obstacle is moved from outside between steps") {
  Case c = ball_below();
  c.set("load.0.vector", {0, 0, 0});
  Simulation s(PETSC_COMM_WORLD, c);
  CHECK(same(s.obstacle("ball"), {0.8, 0.125, -0.12}));
  CHECK(s.advance_to(0.02));
  CHECK(std::abs(tip_height(s)) < 1e-9);
  s.set_obstacle("ball", {0.8, 0.125, -0.06}, 0.06);
  CHECK(s.advance_to(0.04));
  CHECK(s.obstacle("ball")[2] == doctest::Approx(-0.09));
  CHECK(s.run());
  CHECK(s.obstacle("ball")[2] == -0.06);
  CHECK(tip_height(s) > 0.03);
  CHECK(s.energy().obstacles > 0.0);
  CHECK(s.field("contact_pressure").values.size() == static_cast<std::size_t>(s.vertex_count()));
  CHECK_THROWS_AS(s.set_obstacle("bell", {0, 0, 0}, 1.0), UserError);
  CHECK_THROWS_AS(s.set_obstacle("ball", {0, 0, 0, 1, 1, 1}, 1.0), UserError);
  CHECK_THROWS_AS(s.set_obstacle("ball", {0, 0, 0}, s.time()), UserError);
}

TEST_CASE("residual and tangent are those of Newton's method") {
  Case c = strip("static");
  c.set("load.0.vector", {0, 0, 0});
  Simulation s(PETSC_COMM_WORLD, c);
  s.set_forces(tip_forces(s, 0.1));
  Vec x = s.unknowns();
  double first = 0.0, last = 0.0;
  for (int k = 0; k < 12; ++k) {
    Vec r = s.residual(x), dx = nullptr;
    Mat tangent = s.tangent(x);
    VecNorm(r, NORM_2, k == 0 ? &first : &last);
    VecDuplicate(x, &dx);
    KSP ksp = nullptr;
    PC pc = nullptr;
    KSPCreate(PETSC_COMM_WORLD, &ksp);
    KSPSetOperators(ksp, tangent, tangent);
    KSPSetType(ksp, KSPPREONLY);
    KSPGetPC(ksp, &pc);
    PCSetType(pc, PCLU);
    PCFactorSetMatSolverType(pc, MATSOLVERMUMPS);
    KSPSolve(ksp, r, dx);
    VecAXPY(x, -1.0, dx);
    KSPDestroy(&ksp);
    MatDestroy(&tangent);
    VecDestroy(&dx);
    VecDestroy(&r);
  }
  CHECK(last < 1e-8 * first);
  // Derivative in a direction that bends the strip, where it is bent far.
  Vec slope = nullptr;
  VecDuplicate(x, &slope);
  Mat tangent = s.tangent(x);
  MatMult(tangent, x, slope);
  constexpr double h = 1e-6;
  VecScale(x, 1.0 + h);
  Vec above = s.residual(x);
  VecScale(x, (1.0 - h) / (1.0 + h));
  Vec below = s.residual(x);
  VecScale(x, 1.0 / (1.0 - h));
  VecAXPY(above, -1.0, below);
  VecAXPY(above, -2.0 * h, slope);
  double off = 0.0, size = 0.0;
  VecNorm(above, NORM_2, &off);
  VecNorm(slope, NORM_2, &size);
  CHECK(off < 1e-6 * 2.0 * h * size);
  MatDestroy(&tangent);
  for (Vec* v : {&slope, &above, &below}) VecDestroy(v);
  const std::vector<double> u = s.to_array(x);
  Simulation known(PETSC_COMM_WORLD, c);
  known.set_forces(tip_forces(known, 0.1));
  CHECK(known.run());
  CHECK(difference(known.displacements(), u) < 1e-7);
  Vec back = s.to_unknowns(u);
  CHECK(difference(s.to_array(back), u) < 1e-15);
  VecDestroy(&back);
  VecDestroy(&x);
}

TEST_CASE("a new mesh is told, takes forces from outside away, and is gone back on") {
  Case c = Case::parse(strip("dynamic").source() +
                       "[remesh]\nsmallest = 0.03\nlargest = 0.2\nangle = 5\nevery = 1\nenergy_change = 1.0\n");
  c.set("load.0.vector", {0, 0, 0}).set("time.end", 0.6);
  Simulation s(PETSC_COMM_WORLD, c);
  s.set_forces(tip_forces(s, 1.0));
  const State start = s.save();
  const std::vector<double> x = s.positions();
  bool exchanged = false;
  while (!s.finished() && !exchanged) exchanged = s.advance().new_mesh;
  REQUIRE(exchanged);
  CHECK(s.positions().size() != x.size());
  CHECK(s.energy().external == 0.0);
  s.restore(start);
  CHECK(same(s.positions(), x));
  CHECK(s.advance().accepted);
  CHECK(s.energy().external < -1e-12);
}

}  // namespace voile::test_coupling

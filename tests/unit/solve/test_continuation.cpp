// Continuation, and what solvers do where a step does not converge: failures that are reported, recoveries that happen.
#include <doctest/doctest.h>

#include <limits>

#include "solve/newton.hpp"
#include "test_model_kit.hpp"
#include "test_newton_kit.hpp"

namespace test_continuation {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::newton;

namespace {

bool is_finite(const std::vector<Vec3>& u) {
  return std::all_of(u.begin(), u.end(), [](const Vec3& x) { return x.allFinite(); });
}

/// A shallow arch between hinges with a dead load at its crown; it snaps through near load factor 0.7.
mesh::MeshData arch() {
  mesh::MeshData d = grid(12, 2, true, 0.0);
  add_square_groups(d);
  d.groups.push_back({"crown", 0, {6, 19, 32}, {}, {}});
  return mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.2 * x[1], 0.24 * x[0] * (1.0 - x[0])); });
}

system::ModelInput pressed_arch() {
  system::ModelInput input;
  input.materials = {isotropic(1e6, 0.3, 0.01)};
  input.supports = {support("left", Kind::hinged), support("right", Kind::hinged)};
  input.loads = {load(LoadKind::point, "crown", Vec3(0.0, 0.0, -0.1))};
  return input;
}

}  // namespace

TEST_CASE("continuation moves prescribed edges to the same equilibrium as Newton") {
  const Tight tight;
  TurnedPanel by_step(oblique_turn()), by_continuation(oblique_turn());
  solve::Newton first(by_step.model), second(by_continuation.model);
  REQUIRE(first.step(by_step.a).converged);
  const solve::NewtonResult result = second.continuation(by_continuation.a);
  CAPTURE(result.reason);
  REQUIRE(result.converged);
  CHECK(result.factorisations > 0);
  CHECK(difference(by_step.turned_back(), by_continuation.turned_back()) < 1e-9);
}

TEST_CASE("a diverging step says so and leaves the solver usable") {
  const mesh::SurfaceMesh mesh(strip(16, 2));
  system::Model model(PETSC_COMM_WORLD, mesh, cantilever());
  solve::Newton newton(model), fresh(model);
  petsc::VecHandle a = model.dofs().create_vector();
  const auto small_load = [&](solve::Newton& solver) {
    model.conditions().set_load_factor(0.05);
    VOILE_PETSC(VecZeroEntries(a));
    CHECK(solver.step(a).converged);
    return per_vertex(model, a);
  };
  const std::vector<Vec3> expected = small_load(fresh);
  for (const double factor : {400.0, 1e160, std::numeric_limits<double>::quiet_NaN()}) {
    CAPTURE(factor);
    model.conditions().set_load_factor(factor);
    VOILE_PETSC(VecZeroEntries(a));
    const solve::NewtonResult result = newton.step(a);
    CHECK_FALSE(result.converged);
    CHECK_FALSE(result.reason.empty());
    const std::vector<Vec3> u = small_load(newton);
    CHECK(is_finite(u));
    CHECK(difference(u, expected) < 1e-12);
  }
}

TEST_CASE("a sheet without supports is not reported as solved") {
  const mesh::SurfaceMesh mesh(strip(16, 2));
  system::ModelInput input = cantilever();
  input.supports.clear();
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  solve::Newton newton(model);
  model.conditions().set_load_factor(1.0);
  petsc::VecHandle a = model.dofs().create_vector();
  const solve::NewtonResult result = newton.step(a);
  CHECK_FALSE(result.converged);
  CHECK_FALSE(result.reason.empty());
}

TEST_CASE("continuation finds the equilibrium that stepping finds") {
  const mesh::SurfaceMesh mesh(strip(16, 2));
  const Tight tight;
  system::Model model(PETSC_COMM_WORLD, mesh, cantilever());
  solve::Newton newton(model);
  petsc::VecHandle a = model.dofs().create_vector(), b = model.dofs().create_vector();
  model.conditions().set_load_factor(0.5);
  REQUIRE(newton.step(a).converged);
  const solve::NewtonResult result = newton.continuation(b);
  CAPTURE(result.reason);
  REQUIRE(result.converged);
  const std::vector<Vec3> u = per_vertex(model, a);
  CHECK(largest(u) > 4.0);
  CHECK(difference(u, per_vertex(model, b)) < 1e-7);  // -snes_stol 1e-11 of the unknowns, times the slenderness
}

TEST_CASE("continuation settles where the decrease of the energy drowns in its round-off") {
  // A fine, slender strip: its energy is a small sum of large terms. Shows on two ranks; on others the rounding
  // differs.
  const mesh::SurfaceMesh mesh(strip(40, 16));
  system::Model model(PETSC_COMM_WORLD, mesh, cantilever());
  solve::Newton newton(model);
  petsc::VecHandle a = model.dofs().create_vector(), b = model.dofs().create_vector();
  for (const double factor : {0.02, 0.05, 0.08}) {
    CAPTURE(factor);
    model.conditions().set_load_factor(factor);
    VOILE_PETSC(VecZeroEntries(a));
    VOILE_PETSC(VecZeroEntries(b));
    CHECK(newton.step(a).converged);
    const solve::NewtonResult result = newton.continuation(b);
    CAPTURE(result.reason);
    CHECK(result.converged);
    CHECK(result.factorisations < 60);
    CHECK(difference(per_vertex(model, a), per_vertex(model, b)) < 1e-6 * largest(per_vertex(model, a)));
  }
}

TEST_CASE("continuation passes a snap that one step does not") {
  const mesh::SurfaceMesh mesh(arch());
  system::Model model(PETSC_COMM_WORLD, mesh, pressed_arch());
  solve::Newton newton(model);
  petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
  model.conditions().set_load_factor(1.0);
  const double before = model.energy(a);
  CHECK_FALSE(newton.step(a).converged);
  VOILE_PETSC(VecZeroEntries(a));
  const solve::NewtonResult result = newton.continuation(a);
  CAPTURE(result.reason);
  REQUIRE(result.converged);
  CHECK(result.negative_pivots == 0);  // a stable state
  const double crown = per_vertex(model, a)[19].z();
  CHECK(crown < -0.10);  // from 0.06 above the hinges to as far below
  CHECK(crown > -0.14);
  CHECK(model.energy(a) < before);
  model.residual(a, r);
  CHECK(norm(r) < 1e-7 * model.force_scale());
}

TEST_CASE("MUMPS's lack of workspace is answered with more of it") {
  const mesh::SurfaceMesh mesh(strip(24, 10));
  const auto solve = [&](bool continuation) {
    system::Model model(PETSC_COMM_WORLD, mesh, cantilever());
    solve::Newton newton(model);
    model.conditions().set_load_factor(0.05);
    petsc::VecHandle a = model.dofs().create_vector();
    const solve::NewtonResult result = continuation ? newton.continuation(a) : newton.step(a);
    CAPTURE(result.reason);
    CHECK(result.converged);
    return std::pair(result.factorisations, per_vertex(model, a));
  };
  for (const bool continuation : {false, true}) {
    CAPTURE(continuation);
    const auto enough = solve(continuation);
    const Option hopeless("-mat_mumps_icntl_14", "-60");
    const auto starved = solve(continuation);
    CHECK(starved.first > enough.first);  // the failure did happen
    CHECK(difference(starved.second, enough.second) < 1e-6 * largest(enough.second));
  }
}

TEST_CASE("an unstable equilibrium is reported by its negative pivots") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 10));
  system::ModelInput input;
  input.materials = {isotropic(1e4, 0.3, 0.01)};
  input.supports = {support("left", Kind::hinged), displacement("right", {true, true, true}, Vec3(-1e-3, 0.0, 0.0))};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  solve::Newton newton(model);
  petsc::VecHandle a = model.dofs().create_vector();
  // A wide column buckles near the strain pi^2 h^2/(12 (1 - nu^2)) = 9e-5.
  model.conditions().set_load_factor(0.03);
  const solve::NewtonResult stable = newton.step(a);
  CHECK(stable.converged);
  CHECK(stable.negative_pivots == 0);
  model.conditions().set_load_factor(1.0);
  const solve::NewtonResult buckled = newton.step(a);
  CHECK(buckled.converged);
  for (const Vec3& u : per_vertex(model, a)) CHECK(std::abs(u.z()) < 1e-12);  // nothing pushes it out of its plane
  CHECK(buckled.negative_pivots >= 3);                                        // (k pi h)^2/10.92 < 1e-3 for k = 1, 2, 3
}

}  // namespace test_continuation

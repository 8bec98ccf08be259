// Draping: equilibria are in balance and stable; unstable ones are left. Heavy strips against the elastica.
#include <doctest/doctest.h>

#include <cmath>

#include "linear/inverse_iteration.hpp"
#include "solve/drape.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"

namespace test_drape {

using namespace voile;
using namespace voile::testing;
using SupportKind = system::Support::Kind;
using LoadKind = system::Load::Kind;

namespace {

/// A strip of length 1 clamped at one end under its own weight; Gamma = w L^3 / D.
struct HeavyStrip {
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  HeavyStrip(double gamma, int cells, bool alternate)
      : mesh(data(cells, alternate)), model(PETSC_COMM_WORLD, mesh, input(gamma)), a(model.dofs().create_vector()) {}
  static mesh::MeshData data(int cells, bool alternate) {
    mesh::MeshData d = grid(cells, 2, alternate, 0.0);
    add_square_groups(d);
    return mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.1 * x[1], 0.0); });
  }
  static system::ModelInput input(double gamma) {
    system::ModelInput in;
    energy::Material m = isotropic(1.0, 0.0, 1.0, 0.2);
    m.membrane = energy::isotropic_membrane(2000.0, 0.0, 1.0);
    m.bending = energy::isotropic_membrane(0.2 * 9.81 / gamma, 0.0, 1.0);
    in.materials = {m};
    in.supports = {support("left", SupportKind::clamped)};
    in.loads = {load(LoadKind::gravity, "", Vec3(0.0, 0.0, -9.81))};
    return in;
  }
  /// Drop over reach of the free end.
  [[nodiscard]] double drop_over_reach() const {
    const std::vector<Vec3> u = per_vertex(model, a);
    double drop = 0.0, reach = 0.0;
    for (Index v : mesh.group("right").vertices) {
      drop -= u[v][2] / 3.0;
      reach += (mesh.positions()[v][0] + u[v][0]) / 3.0;
    }
    return drop / reach;
  }
};

}  // namespace

TEST_CASE("heavy strips hang as the elastica does") {
  // H/W of an inextensible strip clamped horizontally, integrated independently to the digits shown.
  struct Row {
    double gamma, drop_over_reach;
    int cells;
  };
  for (const Row row : {Row{1.0, 0.124562, 16}, Row{10.0, 1.066802, 24}, Row{100.0, 5.888105, 40}})
    for (const bool alternate : {false, true}) {
      CAPTURE(row.gamma);
      CAPTURE(alternate);
      HeavyStrip strip(row.gamma, row.cells, alternate);
      strip.model.conditions().set_load_factor(1.0);
      solve::Drape drape(strip.model, {});
      const Ended r = follow_from(state_of(strip.a), drape);
      REQUIRE(r.completed);
      REQUIRE(r.newton.converged);
      CHECK(drape.stability().stable);
      CHECK(drape.stability().eigenvalue > 0.0);
      CHECK(r.newton.residual < 1e-6);
      CHECK(strip.drop_over_reach() == relative(row.drop_over_reach).epsilon(0.01));
    }
}

TEST_CASE("an unstable equilibrium is left for a stable one") {
  // A strip pressed lengthwise beyond Euler's load is in equilibrium straight, but not stably.
  mesh::MeshData d = grid(16, 2, true, 0.0);
  add_square_groups(d);
  const mesh::SurfaceMesh mesh(mapped(d, [](const Vec3& x) { return Vec3(x[0], 0.2 * x[1], 0.0); }));
  system::ModelInput in;
  in.materials = {isotropic(1e6, 0.0, 0.01)};
  system::Support slide = support("right", SupportKind::displacement);
  slide.components = {false, true, true};
  in.supports = {support("left", SupportKind::hinged), slide};
  const double euler = 9.8696 * 1e6 * 1e-6 / 12.0;
  in.loads = {load(LoadKind::line, "right", Vec3(-1.1 * euler, 0.0, 0.0))};
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  model.conditions().set_load_factor(1.0);
  petsc::VecHandle a = model.dofs().create_vector();
  std::vector<std::string> remarks;
  solve::Drape drape(model, {});
  drape.on_remark([&](const std::string& text) { remarks.push_back(text); });
  REQUIRE(follow_from(state_of(a), drape).completed);
  CHECK(drape.stability().stable);
  CHECK(drape.stability().escapes >= 1);
  REQUIRE(remarks.size() == static_cast<std::size_t>(drape.stability().escapes) + 2);
  CHECK(remarks.front().find("1 negative pivot") != std::string::npos);
  double largest = 0.0;
  for (const Vec3& u : per_vertex(model, a)) largest = std::max(largest, std::abs(u[2]));
  CHECK(largest == relative(0.255).epsilon(0.05));  // elastica at 1.1 of Euler's load
  // Without escapes the truth is told.
  petsc::VecHandle b = model.dofs().create_vector();
  solve::DrapeOptions none;
  none.max_escapes = 0;
  solve::Drape at_once(model, none);
  system::State straight = state_of(b);
  CHECK(at_once.begin(straight).outcome == solve::Outcome::accepted);
  const solve::StepResult end = at_once.advance(straight);
  CHECK(end.outcome == solve::Outcome::failed);
  CHECK(end.worth_keeping);
  CHECK(end.reason.find("unstable") != std::string::npos);
  CHECK(end.newton.converged);
  CHECK_FALSE(at_once.stability().stable);
  CHECK(end.newton.negative_pivots == 1);
}

TEST_CASE("inverse iteration finds the eigenvalue nearest to zero") {
  HeavyStrip strip(10.0, 8, false);
  solve::Newton newton(strip.model);
  strip.model.assemble_tangent(strip.a, {.kind = energy::Tangent::exact});
  newton.linear_solver().tangent_changed();
  petsc::VecHandle mode = linear::start_mode(strip.model), product = strip.model.dofs().create_vector(),
                   inertia = strip.model.dofs().create_vector();
  const double value = linear::inverse_iteration(strip.model, newton.linear_solver(), mode, 60);
  CHECK(value > 0.0);
  VOILE_PETSC(MatMult(strip.model.tangent().matrix(), mode, product));
  VOILE_PETSC(VecPointwiseMult(inertia, strip.model.potential().constant().mass(), mode));
  strip.model.dofs().clear_fixed(inertia);
  VOILE_PETSC(VecAXPY(product, -value, inertia));
  CHECK(norm(product) < 1e-6 * value * norm(inertia));
}

}  // namespace test_drape

// Newton and continuation: exact states, iteration counts, failures that are reported, and recoveries that happen.
//
// Reference for the cantilever: Sze, Liu & Lo, Finite Elem. Anal. Des. 40 (2004) 1551-1569, end shear, S4R column:
// L = 10, b = 1, h = 0.1, E = 1.2e6, nu = 0, P = 4: -u = 3.286, w = 6.698.
#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "solve/load_path.hpp"
#include "solve/newton.hpp"
#include "test_following.hpp"
#include "test_model_kit.hpp"
#include "test_newton_kit.hpp"
#include "test_relative.hpp"

namespace test_newton {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::newton;

namespace {

/// Residual norms of a solve, by iteration.
PetscErrorCode record_norm(SNES, PetscInt, PetscReal norm, void* to) {
  static_cast<std::vector<double>*>(to)->push_back(norm);
  return 0;
}

/// n x n cells on the unit square, each cut by both diagonals: mirror-symmetric about every line of the grid.
mesh::MeshData crossed(int n) {
  mesh::MeshData d;
  d.source = "crossed";
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) d.positions.push_back({1.0 * i / n, 1.0 * j / n, 0.0});
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const auto centre = static_cast<Index>(d.positions.size());
      d.positions.push_back({(i + 0.5) / n, (j + 0.5) / n, 0.0});
      const Index a = j * (n + 1) + i, b = a + 1, c = b + n + 1, e = a + n + 1;
      d.triangles.insert(d.triangles.end(), {{a, b, centre}, {b, c, centre}, {c, e, centre}, {e, a, centre}});
    }
  add_square_groups(d);
  return d;
}

}  // namespace

TEST_CASE("a stretched and carried sheet is exact, reactions included, and its supports move in the first step") {
  const mesh::SurfaceMesh mesh(square(Pattern::jittered, 7));
  const Vec3 carried(0.0, 0.0, 0.3);
  system::ModelInput input;
  input.materials = {isotropic(100.0, 0.3, 0.01)};
  input.supports = {displacement("left", {true, true, true}, carried),
                    displacement("right", {true, true, true}, carried + Vec3(0.1, 0.0, 0.0)),
                    displacement("bottom", {false, true, false}, Vec3::Zero()),
                    displacement("top", {false, true, false}, Vec3::Zero())};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  solve::Newton newton(model);
  model.conditions().set_load_factor(1.0);
  petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector(),
                   moved = model.dofs().create_vector();
  // What the residual would be if the supports moved alone.
  set_displacement(model, moved, [&](Index v) {
    const double x = mesh.positions()[v].x();
    return x == 0.0 ? carried : x == 1.0 ? Vec3(carried + Vec3(0.1, 0.0, 0.0)) : Vec3(Vec3::Zero());
  });
  model.residual(moved, r);
  const double alone = norm(r);
  std::vector<double> norms;
  VOILE_PETSC(SNESMonitorSet(newton.snes(), record_norm, &norms, nullptr));
  const solve::NewtonResult result = newton.step(a);
  CHECK(result.converged);
  CHECK(result.iterations <= 6);
  CHECK(result.negative_pivots == 0);
  REQUIRE(norms.size() > 2);
  CHECK(norms[1] < 1e-3 * alone);

  const std::vector<Vec3> u = per_vertex(model, a);
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    CHECK((u[v] - carried - Vec3(0.1 * mesh.positions()[v].x(), 0.0, 0.0)).norm() < 1e-10);
  // St Venant-Kirchhoff: N11 = A11 E11 in the rest frame, nominal force per width (1 + e) N11.
  const double strain = 0.1 + 0.5 * 0.1 * 0.1, n11 = input.materials[0].membrane(0, 0) * strain;
  model.unbalanced_force(a, r);
  const std::vector<Vec3> f = per_vertex(model, r);
  Vec3 left = Vec3::Zero(), right = Vec3::Zero(), top = Vec3::Zero();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3& x = mesh.positions()[v];
    if (x.x() == 0.0) left += f[v];
    if (x.x() == 1.0) right += f[v];
    if (x.y() == 1.0) top += f[v];
  }
  CHECK((right - Vec3(1.1 * n11, 0.0, 0.0)).norm() < 1e-10 * n11);
  CHECK((left + right).norm() < 1e-10 * n11);
  CHECK(top.y() == relative(input.materials[0].membrane(0, 1) * strain).epsilon(1e-10));
  const system::TriangleFields fields = model.triangle_fields(a);
  for (std::size_t i = 0; i < fields.membrane_force.size(); i += 3)
    CHECK(std::abs(fields.membrane_force[i] - n11) < 1e-10 * n11);
}

TEST_CASE("a start in equilibrium is accepted, whatever its round-off") {
  const mesh::SurfaceMesh mesh(strip(8, 2));
  system::Model model(PETSC_COMM_WORLD, mesh, cantilever());
  solve::Newton newton(model);
  petsc::VecHandle a = model.dofs().create_vector();
  // No load at all: the residual is nothing but round-off, and there is nothing to compare it with.
  const solve::NewtonResult idle = newton.step(a);
  CHECK(idle.converged);
  CHECK(idle.iterations <= 1);
  CHECK(norm(a) < 1e-12);
  // The same load twice.
  model.conditions().set_load_factor(0.01);
  CHECK(newton.step(a).converged);
  const std::vector<Vec3> u = per_vertex(model, a);
  const solve::NewtonResult again = newton.step(a);
  CHECK(again.converged);
  CHECK(again.iterations <= 3);
  CHECK(difference(u, per_vertex(model, a)) < 1e-9 * largest(u));
  // A load that leaves a strain of about the round-off still deflects.
  VOILE_PETSC(VecZeroEntries(a));
  model.conditions().set_load_factor(1e-9);
  CHECK(newton.step(a).converged);
  CHECK(per_vertex(model, a)[9 + 8].z() == relative(4e-9 * 1000.0 / (3.0 * 100.0)).epsilon(0.01));
}

TEST_CASE("supports that carry a sheet without straining it need no force") {
  const mesh::SurfaceMesh mesh(strip(8, 2));
  system::ModelInput input = cantilever();
  input.supports[0].value = Vec3(0.3, -0.2, 4.0);
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  solve::Newton newton(model);
  petsc::VecHandle a = model.dofs().create_vector();
  model.conditions().set_load_factor(0.0);
  CHECK(newton.step(a).converged);
  input.loads.clear();
  system::Model unloaded(PETSC_COMM_WORLD, mesh, input);
  solve::Newton mover(unloaded);
  unloaded.conditions().set_load_factor(1.0);
  const solve::NewtonResult result = mover.step(a);
  CAPTURE(result.reason);
  CHECK(result.converged);
  CHECK(result.iterations <= 3);
  for (const Vec3& u : per_vertex(unloaded, a)) CHECK((u - input.supports[0].value).norm() < 1e-10);
}

TEST_CASE("the coupling to prescribed components is the derivative of the residual, oblique axes included") {
  TurnedPanel panel(oblique_turn());
  system::Model& model = panel.model;
  const int rank = mpi::rank(model.dofs().comm());
  const Index first = model.dofs().partition().owned_begin(rank);
  int rotated = 0;
  for (const auto& [v, s] : model.discretisation().constraints().vertices) rotated += s.rotated() ? 1 : 0;
  REQUIRE(rotated > 5);
  set_displacement(model, panel.a, noise(0.02, 3));
  petsc::VecHandle off = model.dofs().create_vector(), moved = model.dofs().create_vector(),
                   plus = model.dofs().create_vector(), minus = model.dofs().create_vector(),
                   coupling = model.dofs().create_vector();
  const auto for_fixed = [&](const std::function<void(PetscInt, double)>& f) {
    for (const auto& [v, s] : model.discretisation().constraints().vertices)
      if (model.dofs().partition().vertex_rank[v] == rank)
        for (int k = 0; k < 3; ++k)
          if (s.fixed[k])
            f(3 * (model.dofs().partition().row_of[v] - first) + k, model.conditions().load_factor() * s.value[k]);
  };
  model.residual(panel.a, minus);
  {
    const petsc::ReadArray unknown(panel.a), r(minus);
    const petsc::WriteArray out(off);
    for_fixed([&](PetscInt i, double prescribed) {
      out[i] = unknown[i] - prescribed;
      CHECK(r[i] == out[i]);  // fixed components of the residual
    });
  }
  REQUIRE(norm(off) > 0.1);
  model.assemble_tangent(panel.a, {.kind = energy::Tangent::exact});
  REQUIRE(model.tangent().fixed_coupling() != nullptr);
  VOILE_PETSC(VecCopy(model.tangent().fixed_coupling(), coupling));
  const double h = 1e-5;
  VOILE_PETSC(VecWAXPY(moved, h, off, panel.a));
  model.residual(moved, plus);
  VOILE_PETSC(VecWAXPY(moved, -h, off, panel.a));
  model.residual(moved, minus);
  VOILE_PETSC(VecAXPY(plus, -1.0, minus));
  VOILE_PETSC(VecScale(plus, 0.5 / h));
  {
    const petsc::WriteArray out(plus);
    const petsc::ReadArray c(coupling);
    for_fixed([&](PetscInt i, double) {
      CHECK(c[i] == 0.0);
      out[i] = 0.0;
    });
  }
  VOILE_PETSC(VecAXPY(plus, -1.0, coupling));
  CHECK(norm(coupling) > 1.0);
  CHECK(norm(plus) < 1e-6 * norm(coupling));  // h^2 and round-off/h are both about 1e-9 of the stiffness
  // The supports in place: nothing to couple.
  VOILE_PETSC(VecAXPY(panel.a, -1.0, off));
  model.residual(panel.a, minus);
  double left = 0.0;
  {
    const petsc::ReadArray r(minus);
    for_fixed([&](PetscInt i, double) { left = std::max(left, std::abs(r[i])); });
  }
  CHECK(left < 1e-16);
}

TEST_CASE("a problem turned in space has the turned solution") {
  const Tight tight;
  TurnedPanel straight(Mat3::Identity()), turned(oblique_turn());
  for (TurnedPanel* p : {&straight, &turned}) {
    solve::Newton newton(p->model);
    const solve::NewtonResult result = newton.step(p->a);
    CAPTURE(result.reason);
    REQUIRE(result.converged);
  }
  const std::vector<Vec3> u = straight.turned_back();
  CHECK(largest(u) > 0.03);
  CHECK(difference(u, turned.turned_back()) < 1e-9 * largest(u));
}

TEST_CASE("the cantilever takes its full end shear in one step of few iterations") {
  const mesh::SurfaceMesh mesh(strip(40, 4));
  system::Model model(PETSC_COMM_WORLD, mesh, cantilever());
  solve::Newton newton(model);
  model.conditions().set_load_factor(1.0);
  petsc::VecHandle a = model.dofs().create_vector();
  const solve::NewtonResult result = newton.step(a);
  CHECK(result.converged);
  CHECK(result.iterations <= 8);
  CHECK(result.factorisations <= 8);
  CHECK(result.negative_pivots == 0);
  const Vec3 tip = per_vertex(model, a)[41 * 2 + 40];
  CHECK(-tip.x() == relative(3.286).epsilon(0.002));
  CHECK(tip.z() == relative(6.698).epsilon(0.002));
  CHECK(std::abs(tip.y()) < 1e-3);  // the diagonals are not symmetric
}

TEST_CASE("a quarter between oblique symmetry planes is the whole") {
  const Tight tight;
  constexpr int n = 5;
  const Mat3 turn = oblique_turn();
  struct Case {
    energy::BendingOperator bending;
    double rise;
    energy::MembraneOperator membrane = energy::MembraneOperator::six_node;
    double tolerance = 1e-8;
  };
  // On a curved rest shape the slope of edge_slope on a mirrored edge equals that of the whole mesh only to the order
  // of the method; six_node has no such slope, and on a flat mesh with symmetric boundary triangles both are exact.
  // The corrected membrane sees a ring of vertices more, of which only the nearest have mirror points.
  for (const Case c :
       {Case{energy::BendingOperator::edge_slope, 0.0}, Case{energy::BendingOperator::edge_angle, 0.0},
        Case{energy::BendingOperator::six_node, 0.0}, Case{energy::BendingOperator::six_node, 0.2},
        Case{energy::BendingOperator::edge_slope, 0.0, energy::MembraneOperator::six_node_corrected, 2e-3}}) {
    CAPTURE(static_cast<int>(c.bending));
    CAPTURE(c.rise);
    const auto place = [&](const Vec3& x) {
      return Vec3(turn * Vec3(x[0], x[1], c.rise * (1.0 - x[0] * x[0]) * (1.0 - x[1] * x[1])));
    };
    const mesh::SurfaceMesh whole(
        mapped(crossed(2 * n), [&](const Vec3& x) { return place(Vec3(2.0 * x[0] - 1.0, 2.0 * x[1] - 1.0, 0.0)); }));
    const mesh::SurfaceMesh quarter(mapped(crossed(n), place));
    system::ModelInput input;
    input.element.bending = c.bending;
    input.element.membrane = c.membrane;
    input.materials = {isotropic(1e4, 0.3, 0.05)};
    input.loads = {load(LoadKind::area, "", turn * Vec3(0.0, 0.0, c.rise > 0.0 ? -20.0 : 0.5))};
    system::ModelInput part = input;
    for (const char* edge : {"left", "right", "bottom", "top"}) input.supports.push_back(support(edge, Kind::hinged));
    part.supports = {support("right", Kind::hinged), support("top", Kind::hinged), support("left", Kind::symmetry),
                     support("bottom", Kind::symmetry)};
    part.supports[2].normal = turn * Vec3::UnitX();
    part.supports[3].normal = turn * Vec3::UnitY();
    const auto solved = [&](const mesh::SurfaceMesh& mesh, const system::ModelInput& in) {
      system::Model model(PETSC_COMM_WORLD, mesh, in);
      petsc::VecHandle a = model.dofs().create_vector();
      solve::LoadPath path(model, {});
      CHECK(follow_from(state_of(a), path).completed);
      return per_vertex(model, a);
    };
    const std::vector<Vec3> u = solved(whole, input), q = solved(quarter, part);
    CHECK(largest(u) > 0.05);  // the plate's thickness: well into the nonlinear range
    double worst = 0.0;
    int found = 0;
    for (Index v = 0; v < quarter.vertex_count(); ++v)
      for (Index w = 0; w < whole.vertex_count(); ++w)
        if ((quarter.positions()[v] - whole.positions()[w]).norm() < 1e-9) {
          worst = std::max(worst, (q[v] - u[w]).norm());
          ++found;
        }
    CHECK(found == quarter.vertex_count());
    CHECK(worst < c.tolerance * largest(u));
  }
}

}  // namespace test_newton

// Newton and continuation: exact states, iteration counts, failures that are reported, and recoveries that happen.
//
// Reference for the cantilever: Sze, Liu & Lo, Finite Elem. Anal. Des. 40 (2004) 1551-1569, end shear, S4R column:
// L = 10, b = 1, h = 0.1, E = 1.2e6, nu = 0, P = 4: -u = 3.286, w = 6.698.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <limits>

#include "test_following.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"
#include "voile/solve/load_path.hpp"
#include "voile/solve/newton.hpp"

using namespace voile;
using namespace voile::testing;
using Kind = system::Support::Kind;
using LoadKind = system::Load::Kind;

namespace {

/// Tolerances close to round-off, for comparisons tighter than the defaults of 1e-8 and 1e-6.
struct Tight {
  Option rtol{"-snes_rtol", "1e-12"}, stol{"-snes_stol", "1e-10"};
};

system::Support displacement(const std::string& group, std::array<bool, 3> components, const Vec3& value) {
  system::Support s = support(group, Kind::displacement);
  s.components = components;
  s.value = value;
  return s;
}

double largest(const std::vector<Vec3>& u) {
  double size = 0.0;
  for (const Vec3& x : u) size = std::max(size, x.norm());
  return size;
}

double difference(const std::vector<Vec3>& p, const std::vector<Vec3>& q) {
  REQUIRE(p.size() == q.size());
  double size = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) size = std::max(size, (p[i] - q[i]).norm());
  return size;
}

bool is_finite(const std::vector<Vec3>& u) {
  return std::all_of(u.begin(), u.end(), [](const Vec3& x) { return x.allFinite(); });
}

/// Residual norms of a solve, by iteration.
PetscErrorCode record_norm(SNES, PetscInt, PetscReal norm, void* to) {
  static_cast<std::vector<double>*>(to)->push_back(norm);
  return 0;
}

/// Strip clamped at the left, 10 x 1 x 0.1, end shear 4 at load factor 1.
mesh::MeshData strip(int nx, int ny) {
  mesh::MeshData d = grid(nx, ny, false, 0.0);
  add_square_groups(d);
  return mapped(d, [](const Vec3& x) { return Vec3(10.0 * x[0], x[1], 0.0); });
}

system::ModelInput cantilever() {
  system::ModelInput input;
  input.materials = {isotropic(1.2e6, 0.0, 0.1)};
  input.supports = {support("left", Kind::clamped)};
  input.loads = {load(LoadKind::line, "right", Vec3(0.0, 0.0, 4.0))};
  return input;
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

/// A curved panel in turned space: one edge moved, one in a symmetry plane, under its own weight.
struct TurnedPanel {
  Mat3 turn;
  mesh::SurfaceMesh mesh;
  system::Model model;
  petsc::VecHandle a;

  explicit TurnedPanel(const Mat3& t)
      : turn(t),
        mesh(mapped(square(Pattern::jittered, 8),
                    [&](const Vec3& x) {
                      return Vec3(t * Vec3(x[0], x[1], 0.2 * std::cos(1.2 * (1.0 - x[0])) + 0.15 * x[1] * x[1]));
                    })),
        model(PETSC_COMM_WORLD, mesh, input(t)),
        a(model.dofs().create_vector()) {
    model.conditions().set_load_factor(1.0);
  }

  static system::ModelInput input(const Mat3& t) {
    system::ModelInput in;
    // Which of two patch fits gives an edge its slope is decided by a condition number that depends on the axes; here
    // all fits are used, so that nothing but round-off does.
    in.element.max_patch_condition = 1e6;
    in.materials = {isotropic(3e5, 0.3, 0.02, 0.1)};
    in.supports = {support("left", Kind::hinged), support("right", Kind::symmetry)};
    in.supports[0].value = t * Vec3(-0.02, 0.01, 0.03);
    in.supports[1].normal = t * Vec3::UnitX();
    in.loads = {load(LoadKind::gravity, "", t * Vec3(0.0, 0.3, -9.81))};
    return in;
  }
  /// Displacements in the axes before the turn.
  std::vector<Vec3> turned_back() const {
    std::vector<Vec3> u = per_vertex(model, a);
    for (Vec3& x : u) x = turn.transpose() * x;
    return u;
  }
};

Mat3 oblique_turn() {
  return Eigen::AngleAxisd(0.9, Vec3(1.0, -0.5, 0.8).normalized()).toRotationMatrix();
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
       {Case{energy::BendingOperator::edge_slope, 0.0}, Case{energy::BendingOperator::six_node, 0.0},
        Case{energy::BendingOperator::six_node, 0.2},
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

// What the solver makes of remeshed sheets: elements on halved meshes, energy across a remeshing, and relaxation.
#include <doctest/doctest.h>

#include <cmath>

#include "adapt/transfer.hpp"
#include "solve/relaxation.hpp"
#include "test_adapt_kit.hpp"
#include "test_model_kit.hpp"

namespace test_remeshed {

using namespace voile;
using namespace voile::testing;
using energy::BendingOperator;
using SupportKind = system::Support::Kind;

namespace {

/// The unit square, halved only, finer towards a place beside its middle.
mesh::MeshData halved(int cells, double low) {
  const mesh::SurfaceMesh first(square(Pattern::diagonal, cells));
  const auto h = sizes(first, [&](const Vec3& x) { return low + 0.1 * (x - Vec3(0.4, 0.55, 0.0)).norm(); });
  Options options;
  options.only_splits = true;
  options.rounds = 8;
  Remeshed r = remeshed(first, RestSurface(first), h, {}, options);
  REQUIRE(r.counts.splits > 50);
  REQUIRE(r.counts.collapses + r.counts.flips + r.counts.smoothed == 0);
  return r.mesh;
}

/// Error of a state of constant curvature whose vertices near the boundary are held, over its largest displacement.
double patch_error(BendingOperator op, const Vec3& k) {
  mesh::MeshData data = halved(8, 0.02);
  mesh::Group outer{"outer", 0, {}, {}, {}};
  for (Index v = 0; v < static_cast<Index>(data.positions.size()); ++v)
    if ((data.positions[v].head<2>() - Vec2(0.5, 0.5)).cwiseAbs().maxCoeff() > 0.2) outer.vertices.push_back(v);
  data.groups.push_back(outer);
  const mesh::SurfaceMesh mesh(data);
  system::ModelInput input;
  input.materials = {isotropic(1.0, 0.3, 1.0)};
  input.supports = {support("outer", SupportKind::hinged)};
  input.element.bending = op;
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                   flat = model.dofs().create_vector(), error = model.dofs().create_vector();
  set_displacement(model, a, [&](Index v) {
    const Vec3 x = mesh.positions()[v];
    return Vec3(0.0, 0.0, 0.5 * k[0] * x[0] * x[0] + 0.5 * k[1] * x[1] * x[1] + 0.5 * k[2] * x[0] * x[1]);
  });
  model.potential().constant().multiply_bending(a, f);
  model.dofs().clear_fixed(f);
  model.assemble_tangent(flat, {.kind = energy::Tangent::exact});
  solve_linear(model, f, error);
  double largest = 0.0, scale = 0.0;
  VOILE_PETSC(VecNorm(error, NORM_INFINITY, &largest));
  VOILE_PETSC(VecNorm(a, NORM_INFINITY, &scale));
  return largest / scale;
}

/// Largest deflection of a simply supported unit square under uniform load over that of Navier's series, minus 1.
double plate_error(BendingOperator op, const mesh::MeshData& data) {
  const mesh::SurfaceMesh mesh(data);
  system::ModelInput input;
  energy::Material m = isotropic(1.0, 0.3, 1.0);
  m.bending /= m.bending(0, 0);
  input.materials = {m};
  input.element.bending = op;
  for (const char* edge : {"left", "right", "bottom", "top"})
    input.supports.push_back(support(edge, SupportKind::hinged));
  input.loads = {load(system::Load::Kind::area, "", Vec3(0.0, 0.0, 1.0))};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  model.conditions().set_load_factor(1.0);
  petsc::VecHandle zero = model.dofs().create_vector(), r = model.dofs().create_vector(),
                   a = model.dofs().create_vector();
  model.residual(zero, r);
  model.assemble_tangent(zero, {.kind = energy::Tangent::exact});
  solve_linear(model, r, a);
  double largest = 0.0;
  for (const Vec3& u : per_vertex(model, a)) largest = std::max(largest, std::abs(u[2]));
  return largest / 0.00406235 - 1.0;
}

/// Bent to a cylinder of radius 0.5 without stretch.
Vec3 rolled(const Vec3& x) {
  constexpr double radius = 0.5;
  return {radius * std::sin(x[0] / radius), x[1], radius * (1.0 - std::cos(x[0] / radius))};
}

system::ModelInput clamped_left() {
  system::ModelInput input;
  input.materials = {isotropic(1e6, 0.3, 1e-2, 1.0)};
  input.supports = {support("left", SupportKind::hinged)};
  return input;
}

/// Membrane and bending energy, after relaxation.
double relaxed_energy(const mesh::SurfaceMesh& mesh, const std::vector<Vec3>& places) {
  system::Model model(PETSC_COMM_WORLD, mesh, clamped_left());
  petsc::VecHandle a = model.dofs().create_vector();
  set_displacement(model, a, [&](Index v) { return Vec3(places[v] - mesh.positions()[v]); });
  (void)solve::relax(model, a, {solve::relaxation_time(model), 2});
  const system::Energies e = system::energies(model, a);
  return e.membrane + e.bending;
}

}  // namespace

TEST_CASE("bending passes the patch test on halved meshes with edge_slope, and fails with six_node") {
  for (const Vec3& k : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
    CHECK(patch_error(BendingOperator::edge_slope, k) < 1e-12);
    CHECK(patch_error(BendingOperator::six_node, k) > 1e-5);
  }
}

TEST_CASE("a simply supported plate on a halved mesh meets the series with edge_slope, and misses it with six_node") {
  const mesh::MeshData fine = halved(48, 0.01);
  CAPTURE(fine.positions.size());
  CHECK(std::abs(plate_error(BendingOperator::edge_slope, fine)) < 1e-3);
  CHECK(std::abs(plate_error(BendingOperator::six_node, fine)) > 1e-2);
}

TEST_CASE("remeshing a bent plate for sizes that it has changes its energy by less than 0.1 %") {
  const mesh::SurfaceMesh first(square(Pattern::gmsh, 16));
  const RestSurface rest(first);
  const auto wanted = [](const Vec3& x) { return 0.03 + 0.05 * std::abs(x[0] - 0.5); };
  const auto places_of = [](const mesh::SurfaceMesh& m) {
    std::vector<Vec3> places;
    for (const Vec3& x : m.positions()) places.push_back(rolled(x));
    return places;
  };
  const mesh::SurfaceMesh suited(adapt::remesh(first, rest, places_of(first), sizes(first, wanted), {}).mesh);
  const std::vector<Vec3> places = places_of(suited);
  // Sizes that ask for some changes, as the next look of a run finds them.
  const auto moved = [&](const Vec3& x) { return wanted(x) * (1.0 + 0.15 * std::sin(17 * x[0] + 11 * x[1])); };
  const Remeshed r = adapt::remesh(suited, rest, places, sizes(suited, moved), {});
  REQUIRE(r.counts.splits + r.counts.collapses + r.counts.flips > 10);
  const mesh::SurfaceMesh next(r.mesh);
  const double before = relaxed_energy(suited, places);
  const double after = relaxed_energy(next, adapt::transfer(suited, r, places, adapt::Interpolation::smooth));
  CAPTURE(before);
  CHECK(std::abs(after / before - 1.0) < 1e-3);
}

TEST_CASE("relaxation lowers the energy, leaves held vertices, long waves and contact as they are") {
  const mesh::SurfaceMesh mesh(square(Pattern::gmsh, 10));
  system::ModelInput input = clamped_left();
  contact::Obstacle floor;
  floor.name = "floor";
  floor.shape = contact::Obstacle::Shape::plane;
  floor.points = {Vec3(0.0, 0.0, -1e-3)};
  input.contact.active = true;
  input.contact.options.distance = 2e-3;
  input.contact.obstacles = {floor};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector();
  const auto wobble = noise(5e-4, 3);
  set_displacement(model, a, [&](Index v) { return mesh.positions()[v][0] == 0.0 ? Vec3(0, 0, 0) : wobble(v); });
  const std::vector<Vec3> before = per_vertex(model, a);
  const double energy = model.energy(a);
  const solve::Relaxation r = solve::relax(model, a, {solve::relaxation_time(model), 3});
  const std::vector<Vec3> after = per_vertex(model, a);
  CHECK(r.steps > 0);
  CHECK(model.energy(a) < 0.5 * energy);
  double moved = 0.0, least = 1.0;
  for (std::size_t v = 0; v < after.size(); ++v) {
    if (mesh.positions()[v][0] == 0.0) CHECK(after[v] == before[v]);
    moved = std::max(moved, (after[v] - before[v]).cwiseAbs().maxCoeff());
    least = std::min(least, after[v][2] + 1e-3);
  }
  CHECK(r.moved == doctest::Approx(moved));
  CHECK(least > 0.0);
}

TEST_CASE("relaxation keeps what inertia balances") {
  const mesh::SurfaceMesh mesh(square(Pattern::gmsh, 10));
  system::Model model(PETSC_COMM_WORLD, mesh, clamped_left());
  petsc::VecHandle a = model.dofs().create_vector();
  const petsc::VecHandle force = model.dofs().create_vector();
  const auto wobble = noise(5e-4, 7);
  set_displacement(model, a, [&](Index v) { return mesh.positions()[v][0] == 0.0 ? Vec3(0, 0, 0) : wobble(v); });
  model.residual(a, force);
  model.dofs().clear_fixed(force);
  const double energy = model.energy(a), tau = solve::relaxation_time(model);
  const solve::Relaxation kept = solve::relax(model, a, {tau, 3, {}, force});
  CHECK(kept.moved < 1e-12);
  CHECK(model.energy(a) == relative(energy).epsilon(1e-9));
  const solve::Relaxation lost = solve::relax(model, a, {tau, 3});
  CHECK(lost.moved > 1e-4);
  // From rest the force moves what it pulls at.
  petsc::VecHandle rest = model.dofs().create_vector();
  CHECK(solve::relax(model, rest, {tau, 3}).moved < 1e-12);
  CHECK(solve::relax(model, rest, {tau, 3, {}, force}).moved > 1e-5);
  double work = 0.0;
  VOILE_PETSC(VecDot(rest, force, &work));
  CHECK(work > 0.0);
}

TEST_CASE("relaxation of a part leaves what is stored elsewhere") {
  const mesh::SurfaceMesh mesh(square(Pattern::gmsh, 10));
  system::Model model(PETSC_COMM_WORLD, mesh, clamped_left());
  const auto wobble = noise(5e-4, 5);
  const auto noisy = [&](Vec a) {
    set_displacement(model, a, [&](Index v) { return mesh.positions()[v][0] == 0.0 ? Vec3(0, 0, 0) : wobble(v); });
  };
  std::vector<char> stays;
  for (const Vec3& x : mesh.positions()) stays.push_back(x[0] < 0.5);
  petsc::VecHandle a = model.dofs().create_vector();
  noisy(a);
  const std::vector<Vec3> before = per_vertex(model, a);
  const double energy = model.energy(a), tau = solve::relaxation_time(model);
  (void)solve::relax(model, a, {tau, 3, stays});
  const std::vector<Vec3> after = per_vertex(model, a);
  double stayed = 0.0, moved = 0.0;
  for (std::size_t v = 0; v < after.size(); ++v) {
    double& most = stays[v] ? stayed : moved;
    most = std::max(most, (after[v] - before[v]).norm());
  }
  CHECK(moved > 1e-4);
  CHECK(stayed < 1e-3 * moved);
  const double part = model.energy(a);
  noisy(a);
  (void)solve::relax(model, a, {tau, 3});
  CHECK(part < 0.8 * energy);
  CHECK(model.energy(a) < 0.5 * part);
}

}  // namespace test_remeshed

// Sheets that start bent, and tubes: energy, curvature, seams, rigid-body modes, what turns as a whole.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <numbers>

#include "base/decompositions.hpp"
#include "extent.hpp"
#include "test_charts_kit.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"

namespace test_rolled {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::charts;

namespace {

/// Energies of the start.
system::Energies start_energies(const mesh::MeshData& data, const system::ModelInput& in) {
  const mesh::SurfaceMesh mesh(data);
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector();
  return system::energies(model, a);
}

}  // namespace

TEST_CASE("a flat sheet stores the energy of the cylinder that it starts as, open or joined to itself") {
  const double radius = 0.5;
  const double stiffness = isotropic(100.0, 0.0, 0.02).bending(0, 0);
  // Flat, but elsewhere: nothing.
  const Motion m = random_motion(1, false);
  const system::Energies flat = start_energies(
      sheet(24, 6, radius, 0.2, false, [&](const Vec2& p) { return Vec3(m.turn * Vec3(p[0], p[1], 0.0) + m.shift); }),
      free_sheet(0.3));
  CHECK(std::abs(flat.bending) < 1e-20);
  CHECK(std::abs(flat.membrane) < 1e-24);
  for (const auto& shape : {std::pair{false, 1.25}, {false, 0.7}, {true, 0.5}})
    for (const double jitter : {0.0, 0.2}) {
      const bool closed = shape.first;
      const double bent = shape.second;
      CAPTURE(closed);
      CAPTURE(bent);
      CAPTURE(jitter);
      const double expected = 0.5 * stiffness / (bent * bent) * 2.0 * std::numbers::pi * radius;
      std::vector<double> errors;
      for (const int n : {12, 24, 48}) {
        const system::Energies e =
            start_energies(sheet(2 * n, n / 2, radius, jitter, closed, rolled(bent)), free_sheet(0.0));
        errors.push_back(e.bending / expected - 1.0);
        const double angle = std::numbers::pi * radius / (n * bent);  // from cell to cell
        // Second differences of points on the circle, known on equal cells. The ends of an open sheet store less.
        if (jitter == 0.0 && closed)
          CHECK(e.bending / expected ==
                relative(std::pow(2.0 * (1.0 - std::cos(angle)) / (angle * angle), 2)).epsilon(1e-10));
      }
      CHECK(std::abs(errors[2]) < (closed ? 1.5e-3 : 0.05));
      CHECK(std::log2(errors[1] / errors[2]) > (closed ? 1.9 : 0.9));
    }
}

TEST_CASE("the curvature of a rolled sheet is that of the cylinder") {
  const double radius = 0.5, bent = 0.8;
  const mesh::SurfaceMesh mesh(sheet(48, 8, radius, 0.2, false, rolled(bent)));
  system::ModelInput in = free_sheet(0.0);
  in.materials[0].direction = Vec3::UnitX();  // of the flat sheet: round the cylinder
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector();
  const system::TriangleFields f = model.triangle_fields(a);
  if (mpi::rank(model.dofs().comm()) != 0) return;
  double worst = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const double x = mesh.rest_corner(t, 0)[0], y = mesh.rest_corner(t, 0)[1];
    if (x < 0.5 || x > 2.5 || y < 0.2 || y > 0.8) continue;
    for (int k = 0; k < 3; ++k)
      worst =
          std::max(worst, std::abs(f.curvature[3 * static_cast<std::size_t>(t) + k] - (k == 0 ? -1.0 / bent : 0.0)));
  }
  CHECK(worst < 0.02 / bent);
}

TEST_CASE("a tube in two panels is the tube in one; forces, tangents and energies of seams belong together") {
  const double radius = 0.5;
  const mesh::MeshData one = sheet(16, 5, radius, 0.2, true, rolled(radius));
  mesh::MeshData two = one;
  for (std::size_t t = 0; t < two.rest.size(); ++t) {
    const Motion m = random_motion(two.rest[t][0][0] < 1.4 ? 11 : 12, false);
    for (Vec3& x : two.rest[t]) x = m.turn * x + m.shift;
  }
  const mesh::SurfaceMesh first(one), second(two);
  system::Model tube(PETSC_COMM_WORLD, first, free_sheet(0.3)), panels(PETSC_COMM_WORLD, second, free_sheet(0.3));
  const Answers a = ask(tube, noise(0.02, 9)), b = ask(panels, noise(0.02, 9));
  CHECK(difference(b.residual, a.residual) < 1e-12);
  CHECK(difference(b.tangent, a.tangent) < 1e-12);
  CHECK(b.energies[0] == relative(a.energies[0]).epsilon(1e-12));
  CHECK(b.energies[1] == relative(a.energies[1]).epsilon(1e-12));
  const Slopes s = slopes(tube, 0.02);
  CHECK(s.force < 1e-9);
  CHECK(s.tangent < 1e-8);
}

TEST_CASE("a sewn tube in equilibrium has exactly six rigid-body modes") {
  if (mpi::size(PETSC_COMM_WORLD) > 1) return;  // dense eigenvalues
  for (const auto membrane : {energy::MembraneOperator::six_node, energy::MembraneOperator::six_node_corrected})
    for (const Index ny : {4, extent(24, 8)}) {  // the last: cells of aspect 6, with sanitizers 2
      constexpr Index nx = 12;
      CAPTURE(ny);
      mesh::MeshData d = sheet(nx, ny, 0.5, 0.2, true, rolled(0.5));
      system::ModelInput in = free_sheet(0.3);
      in.element.membrane = membrane;
      system::ModelInput free = in;
      for (const auto& [v, axes] :
           {std::pair<Index, std::array<bool, 3>>{0, {true, true, true}},
            {nx / 2, {false, true, true}},
            {ny * nx + nx / 4, {false, true, false}}}) {  // holds no more than the rigid motions
        const std::string name = "point" + std::to_string(v);
        d.groups.push_back({name, 0, {v}, {}, {}});
        in.supports.push_back(support(name, system::Support::Kind::displacement));
        in.supports.back().components = axes;
      }
      const mesh::SurfaceMesh mesh(d);
      system::Model held(PETSC_COMM_WORLD, mesh, in), model(PETSC_COMM_WORLD, mesh, free);
      const std::vector<Vec3> u = equilibrium(held);
      const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector();
      model.residual(a, f);
      const double before = norm(f);
      set_displacement(model, a, [&](Index v) { return u[static_cast<std::size_t>(v)]; });
      model.residual(a, f);
      CHECK(norm(f) < 1e-10 * before);
      CHECK(system::energies(model, a).bending > 1e-4);  // it is under stress
      model.assemble_tangent(a, {.kind = energy::Tangent::exact});
      const Eigen::VectorXd e = eigenvalues(dense_tangent(model));
      for (int i = 0; i < 6; ++i) CHECK(std::abs(e[i]) < 1e-13 * e.maxCoeff());
      CHECK(e[6] > 1e-9 * e.maxCoeff());
    }
}

TEST_CASE("a sewn shell that turns as a whole keeps its energy, and its forces turn along") {
  // A flat sheet as a tube; a curved one, in a chart, that starts in another shape.
  mesh::MeshData bent = mapped(square(Pattern::jittered, 6), [](const Vec3& x) {
    return Vec3(x[0], x[1], 0.25 * std::sin(2.0 * x[0]) + 0.15 * x[1] * x[1]);
  });
  bent = mapped(cut(
                    bent, [](Index) { return 0; }, false),
                [](const Vec3& x) { return Vec3(x[0], x[1], -0.3 * x[0] * x[1]); });
  for (const mesh::MeshData& d : {sheet(12, 4, 0.5, 0.2, true, rolled(0.5)), bent}) {
    const mesh::SurfaceMesh mesh(d);
    system::Model model(PETSC_COMM_WORLD, mesh, free_sheet(0.3));
    const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector();
    const auto u = noise(0.02, 3);
    set_displacement(model, a, u);
    const double energy = model.energy(a);
    model.residual(a, f);
    const std::vector<Vec3> forces = per_vertex(model, f);
    const Motion m = random_motion(8, false);
    set_displacement(
        model, a, [&](Index v) { return Vec3(m.turn * (mesh.positions()[v] + u(v)) + m.shift - mesh.positions()[v]); });
    CHECK(model.energy(a) == relative(energy).epsilon(1e-12));
    model.residual(a, f);
    std::vector<Vec3> turned;
    for (const Vec3& force : forces) turned.push_back(m.turn * force);
    CHECK(difference(per_vertex(model, f), turned) < 1e-12);
  }
}

TEST_CASE("a sheet that starts bent and turns with its clamp keeps its energy, and its forces turn along") {
  const mesh::MeshData flat = square(Pattern::jittered, 6);
  const mesh::SurfaceMesh mesh(
      mapped(cut(
                 flat, [](Index) { return 0; }, false),
             [](const Vec3& x) { return Vec3(x[0], x[1], 0.3 * x[0] * x[0] + 0.1 * x[0] * x[1]); }));
  const auto turn = [](double t) { return Mat3(Eigen::AngleAxisd(t, Vec3::UnitY()).toRotationMatrix()); };
  system::ModelInput in = free_sheet(0.3);
  in.supports = {support("left", system::Support::Kind::clamped)};
  in.supports[0].motion = [&](const Vec3& x, double t) { return Vec3(turn(t) * x - x); };
  in.supports[0].rotation = turn;
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector();
  const double energy = model.energy(a);
  REQUIRE(energy > 0.0);
  model.unbalanced_force(a, f);
  std::vector<Vec3> turned = per_vertex(model, f);
  for (Vec3& force : turned) force = turn(0.7) * force;
  model.set_time(0.7);
  set_displacement(model, a, [&](Index v) { return Vec3(turn(0.7) * mesh.positions()[v] - mesh.positions()[v]); });
  CHECK(model.energy(a) == relative(energy).epsilon(1e-12));
  model.unbalanced_force(a, f);
  CHECK(difference(per_vertex(model, f), turned) < 1e-12);
}

}  // namespace test_rolled

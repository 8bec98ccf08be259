// Laminates that couple stretching and bending.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "test_model_kit.hpp"

namespace test_coupling {

using namespace voile;
using namespace voile::testing;

namespace {

enum class Shape { flat, cylinder, saddle };

mesh::MeshData sheet_of(Shape shape) {
  mesh::MeshData d = grid(7, 6, true, 0.2, 5);
  add_square_groups(d);
  return mapped(d, [&](const Vec3& x) {
    if (shape == Shape::cylinder) return Vec3(1.5 * std::sin(x[0]), x[1], 1.5 * std::cos(x[0]));
    return Vec3(x[0], x[1], shape == Shape::saddle ? 0.3 * x[0] * x[0] - 0.2 * x[1] * x[1] : 0.0);
  });
}

energy::Material cross_ply() {
  const energy::LaminateStiffness l =
      energy::laminate(energy::orthotropic_membrane(2e6, 1e5, 0.3, 8e4, 1.0), {{0.3, 0.03}, {1.4, 0.02}});
  energy::Material m;
  m.membrane = l.membrane;
  m.bending = l.bending;
  m.coupling = l.coupling;
  m.layers = l.layers;
  m.direction = Vec3(1.0, 0.2, 0.0);
  m.expands = true;
  energy::set_expansion(m, Vec3(1e-5, 2e-4, 0.0), {0.3 * 180.0 / std::numbers::pi, 1.4 * 180.0 / std::numbers::pi});
  return m;
}

system::ModelInput input(energy::MembraneOperator membrane) {
  system::ModelInput in;
  in.element.membrane = membrane;
  in.materials = {cross_ply()};
  in.natural.by_load = true;
  system::Temperature t;
  t.change = {"", [](const Vec3& x, double) { return 100.0 + 20.0 * x[0]; }, false};
  t.difference = {"", [](const Vec3& x, double) { return 30.0 * x[1]; }, false};
  in.natural.temperatures = {t};
  return in;
}

const std::vector<energy::MembraneOperator> membranes{
    energy::MembraneOperator::six_node_corrected, energy::MembraneOperator::six_node, energy::MembraneOperator::cst};

}  // namespace

TEST_CASE("an unsymmetric laminate: forces derive from the energy, the tangent from the forces") {
  for (const Shape shape : {Shape::flat, Shape::cylinder, Shape::saddle})
    for (const energy::MembraneOperator membrane : membranes) {
      CAPTURE(static_cast<int>(shape));
      CAPTURE(static_cast<int>(membrane));
      const mesh::SurfaceMesh mesh(sheet_of(shape));
      system::ModelInput in = input(membrane);
      in.supports = {support("left", system::Support::Kind::clamped)};
      system::Model model(PETSC_COMM_WORLD, mesh, in);
      model.conditions().set_load_factor(0.7);
      petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
      set_displacement(model, a, noise(0.02, 3));
      model.dofs().clear_fixed(a);
      set_displacement(model, d, noise(0.2, 4));
      model.dofs().clear_fixed(d);
      check_potential(model, a, d);
      // Along the load factor.
      petsc::VecHandle f = model.dofs().create_vector(), up = model.dofs().create_vector(),
                       down = model.dofs().create_vector();
      model.load_direction(a, f);
      model.conditions().set_load_factor(0.71);
      model.residual(a, up);
      model.conditions().set_load_factor(0.69);
      model.residual(a, down);
      VOILE_PETSC(VecAXPY(up, -1.0, down));
      VOILE_PETSC(VecScale(up, 50.0));
      VOILE_PETSC(VecAXPY(up, 1.0, f));
      CHECK(norm(up) < 1e-7 * norm(f));
    }
}

TEST_CASE("an unsymmetric laminate stores the same in any orientation") {
  for (const Shape shape : {Shape::flat, Shape::saddle}) {
    const mesh::SurfaceMesh mesh(sheet_of(shape));
    system::Model model(PETSC_COMM_WORLD, mesh, input(energy::MembraneOperator::six_node_corrected));
    model.conditions().set_load_factor(1.0);
    petsc::VecHandle a = model.dofs().create_vector();
    const auto bent = [&](Index v) { return Vec3(mesh.positions()[v] + noise(0.01, 3)(v)); };
    set_displacement(model, a, [&](Index v) { return Vec3(bent(v) - mesh.positions()[v]); });
    const double before = model.energy(a);
    const Mat3 turn(Eigen::AngleAxisd(1.9, Vec3(0.2, -1.0, 0.4).normalized()));
    set_displacement(model, a,
                     [&](Index v) { return Vec3(turn * bent(v) + Vec3(1.0, 2.0, 3.0) - mesh.positions()[v]); });
    CHECK(model.energy(a) == relative(before).epsilon(1e-9));
  }
}

TEST_CASE("a flat laminate that is stretched and bent evenly has the forces and moments of lamination theory") {
  const mesh::SurfaceMesh mesh(sheet_of(Shape::flat));
  for (const energy::MembraneOperator membrane : membranes) {
    system::ModelInput in = input(membrane);
    in.natural.temperatures.clear();
    in.materials[0].direction = Vec3::UnitX();
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    petsc::VecHandle a = model.dofs().create_vector();
    // Small, so that the strain of the deflection does not count.
    const double small = 1e-7;
    const Vec3 strain(2.0 * small, -small, 3.0 * small), curvature(small, -2.0 * small, 0.5 * small);
    set_displacement(model, a, [&](Index v) {
      const double x = mesh.positions()[v][0], y = mesh.positions()[v][1];
      return Vec3(strain[0] * x + strain[2] * y, strain[1] * y,
                  0.5 * (curvature[0] * x * x + curvature[1] * y * y + curvature[2] * x * y));
    });
    const energy::Material& m = in.materials[0];
    const Vec3 force = m.membrane * strain - m.coupling * curvature,
               moment = m.bending * curvature - m.coupling * strain;
    const system::TriangleFields f = model.triangle_fields(a);
    for (std::size_t i = 0; i < f.membrane_force.size(); ++i) {
      const auto t = static_cast<Index>(i / 3);
      if (mesh.neighbour(t, 0) == no_index || mesh.neighbour(t, 1) == no_index || mesh.neighbour(t, 2) == no_index)
        continue;
      CHECK(std::abs(f.membrane_force[i] - force[static_cast<int>(i % 3)]) < 1e-5 * force.norm());
      CHECK(std::abs(f.bending_moment[i] - moment[static_cast<int>(i % 3)]) < 1e-5 * moment.norm());
    }
  }
}

TEST_CASE("a free laminate that is heated rests where lamination theory says, free sides included") {
  const mesh::SurfaceMesh mesh(sheet_of(Shape::flat));
  for (const energy::MembraneOperator membrane : membranes) {
    system::ModelInput in = input(membrane);
    in.materials[0].direction = Vec3::UnitX();
    const double change = 1e-4;
    in.natural.temperatures[0].change.value = [=](const Vec3&, double) { return change; };
    in.natural.temperatures[0].difference.value = nullptr;
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    model.conditions().set_load_factor(1.0);
    petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
    model.residual(a, r);
    const double held = norm(r);
    const Vec3 strain = change * in.materials[0].expansion, curvature = change * in.materials[0].coupled_curvature;
    set_displacement(model, a, [&](Index v) {
      const double x = mesh.positions()[v][0], y = mesh.positions()[v][1];
      return Vec3(strain[0] * x + strain[2] * y, strain[1] * y,
                  0.5 * (curvature[0] * x * x + curvature[1] * y * y + curvature[2] * x * y));
    });
    model.residual(a, r);
    CHECK(norm(r) < 1e-5 * held);
  }
}

TEST_CASE("a free laminate takes the strain and curvature of lamination theory when it is heated") {
  const energy::Material m = cross_ply();
  // In equilibrium stresses have no resultants: N = sum Q (e - z k - a T) dz = 0, M likewise.
  const double change = 3.0, difference = 2.0, thickness = 0.05;
  const Vec3 strain = change * m.expansion + difference * m.coupled_strain,
             curvature = change * m.coupled_curvature + difference * m.expansion_curvature;
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  double size = 0.0;
  for (const energy::Layer& l : m.layers)
    for (const double g :
         {-std::sqrt(0.6), 0.0, std::sqrt(0.6)}) {  // Gauss: stresses are linear, moments quadratic in z
      const double z = 0.5 * (l.low + l.high) + 0.5 * g * (l.high - l.low),
                   dz = (g == 0.0 ? 4.0 / 9.0 : 5.0 / 18.0) * (l.high - l.low);
      const Vec3 stress = l.stiffness * (strain - z * curvature - (change + difference * z / thickness) * l.expansion);
      force += dz * stress;
      moment += dz * z * stress;
      size += dz * stress.norm();
    }
  CHECK(size > 0.0);
  CHECK(force.norm() < 1e-12 * size);
  CHECK(moment.norm() < 1e-12 * size * thickness);
}

}  // namespace test_coupling

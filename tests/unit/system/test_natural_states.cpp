// Natural states that are not the rest shape: temperature, initial strain, prestress.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>
#include <vector>

#include "test_model_kit.hpp"
#include "voile/errors.hpp"

namespace test_natural_states {

using namespace voile;
using namespace voile::testing;

namespace {

constexpr double young = 2e6, poisson = 0.3, thickness = 0.05, alpha = 1e-4;

using Element = std::pair<energy::BendingOperator, energy::MembraneOperator>;
const std::vector<Element> elements{{energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected},
                                    {energy::BendingOperator::edge_angle, energy::MembraneOperator::six_node_corrected},
                                    {energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node},
                                    {energy::BendingOperator::six_node, energy::MembraneOperator::cst}};

enum class Shape { flat, cylinder, saddle };

mesh::MeshData sheet_of(Shape shape) {
  mesh::MeshData d = grid(8, 6, true, 0.2, 5);
  add_square_groups(d);
  return mapped(d, [&](const Vec3& x) {
    if (shape == Shape::cylinder) return Vec3(1.5 * std::sin(x[0]), x[1], 1.5 * std::cos(x[0]));
    return Vec3(x[0], x[1], shape == Shape::saddle ? 0.3 * x[0] * x[0] - 0.2 * x[1] * x[1] : 0.0);
  });
}

energy::Material expanding() {
  energy::Material m = isotropic(young, poisson, thickness);
  m.layers = {{-0.5 * thickness, 0.5 * thickness, m.membrane / thickness}};
  m.expands = true;
  m.direction = Vec3::UnitX();
  energy::set_expansion(m, Vec3(alpha, alpha, 0.0), {});
  return m;
}

system::Field field(double value, double slope = 0.0) {
  return {"", [=](const Vec3& x, double) { return value + slope * x[0]; }, false};
}

system::ModelInput input(const Element& element, const energy::Material& material) {
  system::ModelInput in;
  in.element.bending = element.first;
  in.element.membrane = element.second;
  in.materials = {material};
  in.natural.by_load = true;
  return in;
}

system::Temperature heat(double change, double difference = 0.0, double slope = 0.0) {
  system::Temperature t;
  if (change != 0.0) t.change = field(change, slope);
  if (difference != 0.0) t.difference = field(difference, slope);
  return t;
}

}  // namespace

TEST_CASE("a free body of one temperature grows to a similar one without force and energy") {
  for (const Shape shape : {Shape::flat, Shape::cylinder, Shape::saddle})
    for (const Element& element : elements) {
      CAPTURE(static_cast<int>(shape));
      CAPTURE(static_cast<int>(element.first));
      CAPTURE(static_cast<int>(element.second));
      const mesh::SurfaceMesh mesh(sheet_of(shape));
      system::ModelInput in = input(element, expanding());
      const double change = 300.0, stretch = 1.0 + alpha * change;
      in.natural.temperatures = {heat(change)};
      system::Model model(PETSC_COMM_WORLD, mesh, in);
      model.conditions().set_load_factor(1.0);
      petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
      model.residual(a, r);
      const double held = norm(r), stored = model.energy(a);
      const double plane =
          young * thickness / (1.0 - poisson) * std::pow(alpha * change * (1.0 + 0.5 * alpha * change), 2);
      if (shape == Shape::flat) CHECK(stored == relative(plane).epsilon(1e-10));
      const Mat3 turn(Eigen::AngleAxisd(0.8, Vec3(0.2, -1.0, 0.4).normalized()));
      set_displacement(model, a, [&](Index v) {
        return Vec3(stretch * (turn * mesh.positions()[v]) - mesh.positions()[v] + Vec3(0.1, 0.2, -0.3));
      });
      model.residual(a, r);
      CHECK(norm(r) < 1e-10 * held);
      CHECK(std::abs(model.energy(a)) < 1e-10 * stored);
      const system::TriangleFields fields = model.triangle_fields(a);
      for (const double n : fields.membrane_force) CHECK(std::abs(n) < 1e-9 * young * thickness);
      for (const double k : fields.curvature) CHECK(std::abs(k) < 1e-9);
    }
}

TEST_CASE("a cylinder grows without force by different strains along its axes") {
  energy::Material m = expanding();
  m.direction = Vec3::UnitY();
  m.initial_strain = Vec3(0.03, -0.02, 0.0);
  for (const Element& element : {elements[0], elements[2]}) {
    const mesh::SurfaceMesh mesh(sheet_of(Shape::flat));
    system::Model model(PETSC_COMM_WORLD, mesh, input(element, m));
    petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
    model.residual(a, r);
    const double held = norm(r);
    set_displacement(model, a,
                     [&](Index v) { return Vec3(-0.02 * mesh.positions()[v][0], 0.03 * mesh.positions()[v][1], 0.0); });
    model.residual(a, r);
    CHECK(norm(r) < 1e-10 * held);
  }
}

TEST_CASE("prestress is the membrane force of the rest shape") {
  energy::Material m = expanding();
  m.prestress = Vec3(100.0, 40.0, 10.0);
  const mesh::SurfaceMesh mesh(sheet_of(Shape::flat));
  system::Model model(PETSC_COMM_WORLD, mesh, input(elements[0], m));
  petsc::VecHandle a = model.dofs().create_vector();
  const system::TriangleFields fields = model.triangle_fields(a);
  for (std::size_t i = 0; i < fields.membrane_force.size(); ++i)
    CHECK(fields.membrane_force[i] == relative(m.prestress[static_cast<int>(i % 3)]).epsilon(1e-11));
}

TEST_CASE("with natural states the forces derive from the energy, and the tangent from the forces") {
  for (const Shape shape : {Shape::flat, Shape::cylinder, Shape::saddle})
    for (const Element& element : elements)
      for (const bool viscous : {false, true}) {
        CAPTURE(static_cast<int>(shape));
        CAPTURE(static_cast<int>(element.first));
        CAPTURE(viscous);
        const mesh::SurfaceMesh mesh(sheet_of(shape));
        energy::Material m = expanding();
        m.prestress = Vec3(2e3, 1e3, 500.0);
        m.initial_strain = Vec3(0.01, -0.02, 0.005);
        system::ModelInput in = input(element, m);
        in.natural.temperatures = {heat(200.0, 0.0, 100.0), heat(0.0, 400.0, 50.0)};
        in.supports = {support("left", system::Support::Kind::clamped)};
        system::Model model(PETSC_COMM_WORLD, mesh, in);
        petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector();
        set_displacement(model, a, noise(0.01, 3));
        model.dofs().clear_fixed(a);
        set_displacement(model, d, noise(0.2, 6));
        model.dofs().clear_fixed(d);
        model.conditions().set_load_factor(0.3);
        if (viscous) model.potential().start_step(a, 0.5);
        model.conditions().set_load_factor(0.8);
        model.potential().count_from(a);
        check_potential(model, a, d);
        // Along the load factor.
        petsc::VecHandle f = model.dofs().create_vector(), up = model.dofs().create_vector(),
                         down = model.dofs().create_vector();
        model.load_direction(a, f);
        model.conditions().set_load_factor(0.81);
        model.residual(a, up);
        model.conditions().set_load_factor(0.79);
        model.residual(a, down);
        VOILE_PETSC(VecAXPY(up, -1.0, down));
        VOILE_PETSC(VecScale(up, 50.0));
        VOILE_PETSC(VecAXPY(up, 1.0, f));
        CHECK(norm(f) > 0.0);
        CHECK(norm(up) < 1e-7 * norm(f));
      }
}

TEST_CASE("a difference through the thickness bends a plate at rest by its moment") {
  for (const Element& element : elements) {
    const mesh::SurfaceMesh mesh(sheet_of(Shape::flat));
    system::ModelInput in = input(element, expanding());
    in.natural.temperatures = {heat(0.0, 50.0)};
    for (const char* side : {"left", "right", "bottom", "top"})
      in.supports.push_back(support(side, system::Support::Kind::clamped));
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    model.conditions().set_load_factor(1.0);
    petsc::VecHandle a = model.dofs().create_vector();
    const double moment = young * std::pow(thickness, 2) / (12.0 * (1.0 - poisson)) * alpha * 50.0;
    const system::TriangleFields fields = model.triangle_fields(a);
    for (std::size_t i = 0; i < fields.bending_moment.size(); ++i)
      CHECK(std::abs(fields.bending_moment[i] - (i % 3 == 2 ? 0.0 : moment)) < 1e-9 * moment);
    // The term of fourth order counts the angle by which the plate is held back from its natural shape.
    const bool fourth = element.second == energy::MembraneOperator::six_node_corrected;
    CHECK(model.energy(a) == relative(moment * alpha * 50.0 / thickness).epsilon(fourth ? 1e-3 : 1e-10));
  }
}

TEST_CASE("a temperature on a material without expansion is refused") {
  const mesh::SurfaceMesh mesh(sheet_of(Shape::flat));
  system::ModelInput in = input(elements[0], isotropic(young, poisson, thickness));
  in.natural.temperatures = {heat(10.0)};
  CHECK_THROWS_WITH_AS(system::Model(PETSC_COMM_WORLD, mesh, in), doctest::Contains("has no expansion"), UserError);
}

}  // namespace test_natural_states

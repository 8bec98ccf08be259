// Every force is the gradient of its energy and every tangent the derivative of its force, by central differences.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "test_model_kit.hpp"
#include "test_relative.hpp"

namespace test_derivatives {

using namespace voile;
using namespace voile::testing;

namespace {

/// A curved, jittered shell with a clamped edge, an oblique symmetry plane and a hinged edge.
mesh::MeshData curved_shell() {
  return mapped(square(Pattern::jittered, 6), [](const Vec3& x) {
    const double c = std::cos(0.6), s = std::sin(0.6);
    const Vec3 y(x[0], x[1], 0.25 * std::sin(2.0 * x[0]) + 0.15 * x[1] * x[1]);
    return Vec3(c * y[0] - s * y[1], s * y[0] + c * y[1], y[2]);  // turned about z: planes oblique to the axes
  });
}

system::ModelInput input_for(energy::BendingOperator bending, energy::MembraneOperator membrane, bool supported) {
  system::ModelInput input;
  input.element.bending = bending;
  input.element.membrane = membrane;
  energy::Material m = isotropic(100.0, 0.3, 0.2, 1.0);
  m.bending(0, 2) = m.bending(2, 0) = 0.1 * m.bending(0, 0);
  m.direction = Vec3(1.0, 0.2, 0.1);
  input.materials = {m};
  if (supported) {
    input.supports = {support("left", system::Support::Kind::clamped),
                      support("right", system::Support::Kind::symmetry), support("top", system::Support::Kind::hinged)};
    input.supports[1].normal = Vec3(std::cos(0.6), std::sin(0.6), 0.0);
    input.supports[2].value = Vec3(0.0, 0.0, 0.0);
  }
  system::Load gravity;
  gravity.kind = system::Load::Kind::gravity;
  gravity.vector = Vec3(0.3, -0.1, -1.0);
  input.loads = {gravity};
  return input;
}

/// Zeroes the fixed unknowns of a perturbation and sets the fixed ones of a state to their values.
void respect_supports(system::Model& model, Vec a) {
  const Index first = model.dofs().partition().owned_begin(mpi::rank(model.dofs().comm()));
  const petsc::WriteArray values(a);
  for (const auto& [v, s] : model.discretisation().constraints().vertices)
    if (model.dofs().partition().vertex_rank[v] == mpi::rank(model.dofs().comm()))
      for (int k = 0; k < 3; ++k)
        if (s.fixed[k]) values[3 * (model.dofs().partition().row_of[v] - first) + k] = 0.0;
}

struct Slope {
  double best = 1e300;  ///< smallest relative error over the steps
  double order = 0.0;   ///< observed between the two largest steps
  double reference = 0.0;
};

/// Compares `exact` with central differences of `value` over a range of steps.
Slope compare(double exact, const std::function<double(double)>& value, double largest_step) {
  Slope s;
  s.reference = std::abs(exact);
  std::vector<double> errors;
  for (double h = largest_step; h > 1e-7; h *= 0.1) {
    const double difference = (value(h) - value(-h)) / (2.0 * h);
    errors.push_back(std::abs(difference - exact) / std::abs(exact));
    s.best = std::min(s.best, errors.back());
  }
  s.order = std::log10(errors[0] / errors[1]);
  return s;
}

void check_derivatives(const mesh::SurfaceMesh& mesh, const system::ModelInput& input, double largest_step = 1e-2) {
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  model.conditions().set_load_factor(0.7);
  petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector(), e = model.dofs().create_vector();
  petsc::VecHandle moved = model.dofs().create_vector(), r = model.dofs().create_vector(),
                   kd = model.dofs().create_vector();
  set_displacement(model, a, noise(0.04, 3));
  set_displacement(model, d, noise(1.0, 5));
  set_displacement(model, e, noise(1.0, 11));
  for (Vec v : {static_cast<Vec>(a), static_cast<Vec>(d), static_cast<Vec>(e)}) respect_supports(model, v);

  const auto at = [&](double h) {
    VOILE_PETSC(VecWAXPY(moved, h, d, a));
    return static_cast<Vec>(moved);
  };
  if (model.conditions().symmetric()) {
    model.residual(a, r);
    const Slope gradient = compare(
        dot(r, d), [&](double h) { return model.energy(at(h)); }, largest_step);
    CHECK(gradient.reference > 1e-3);
    CHECK(gradient.best < 1e-7);
    CHECK(gradient.order > 1.7);
  }
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  VOILE_PETSC(MatMult(model.tangent().matrix(), d, kd));
  const Slope hessian = compare(
      dot(kd, e),
      [&](double h) {
        model.residual(at(h), r);
        return dot(r, e);
      },
      largest_step);
  CHECK(hessian.reference > 1e-3);
  CHECK(hessian.best < 1e-8);
  CHECK(hessian.order > 1.7);
  // With x_k = x the linearised stress is the stress.
  petsc::VecHandle other = model.dofs().create_vector();
  model.assemble_tangent(a, {.kind = energy::Tangent::linearised_stress, .previous = a});
  VOILE_PETSC(MatMult(model.tangent().matrix(), d, other));
  VOILE_PETSC(VecAXPY(other, -1.0, kd));
  CHECK(norm(other) < 1e-12 * norm(kd));
  if (!model.conditions().symmetric()) return;
  VOILE_PETSC(MatMultTranspose(model.tangent().matrix(), d, other));
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  VOILE_PETSC(MatMultTranspose(model.tangent().matrix(), d, other));
  VOILE_PETSC(VecAXPY(other, -1.0, kd));
  CHECK(norm(other) < 1e-12 * norm(kd));
}

}  // namespace

TEST_CASE("energy, force and tangent agree for every operator, flat and curved, free and with mirror points") {
  const mesh::SurfaceMesh flat(square(Pattern::jittered, 6)), curved(curved_shell());
  for (const auto bending :
       {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle, energy::BendingOperator::six_node})
    for (const auto membrane : {energy::MembraneOperator::cst, energy::MembraneOperator::six_node,
                                energy::MembraneOperator::six_node_corrected})
      for (const bool supported : {false, true}) {
        CAPTURE(static_cast<int>(bending));
        CAPTURE(static_cast<int>(membrane));
        CAPTURE(supported);
        check_derivatives(curved, input_for(bending, membrane, supported));
        if (!supported) check_derivatives(flat, input_for(bending, membrane, false));
      }
}

TEST_CASE("beside a crease the corrected membrane is free of stress at rest, and its derivatives agree") {
  const mesh::SurfaceMesh roof(mapped(square(Pattern::jittered, 6), [](const Vec3& x) {
    return Vec3(x[0], x[1], 1.2 * std::abs(x[0] - 0.5) + 0.2 * x[1] * x[1]);
  }));
  for (const auto bending : {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle}) {
    const system::ModelInput input = input_for(bending, energy::MembraneOperator::six_node_corrected, false);
    check_derivatives(roof, input);
    system::Model model(PETSC_COMM_WORLD, roof, input);
    petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
    model.conditions().set_load_factor(0.0);
    model.residual(a, r);
    CHECK(norm(r) < 1e-10);
  }
}

TEST_CASE("derivatives of the corrected membrane agree on slivers, under stress and with mirror points") {
  // Cells of aspect 8 moved at random: patches there have fits over more neighbours, and some cubics are quadratics.
  const mesh::SurfaceMesh slivers(mapped(square(Pattern::jittered, 6), [](const Vec3& x) {
    const double c = std::cos(0.6), s = std::sin(0.6), y = 0.125 * x[1];
    return Vec3(c * x[0] - s * y, s * x[0] + c * y, 0.25 * std::sin(2.0 * x[0]) + 1.2 * y * y);
  }));
  for (const auto bending : {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle})
    for (const bool supported : {false, true}) {
      CAPTURE(supported);
      check_derivatives(slivers, input_for(bending, energy::MembraneOperator::six_node_corrected, supported),
                        bending == energy::BendingOperator::edge_angle ? 1e-3 : 1e-2);  // cells are 0.02 high
    }
}

TEST_CASE("derivatives of the corrected membrane and of bending by angles agree for laminates, flat and curved") {
  // Angle plies: A and D have all their parts, and differ by more than a factor.
  const Mat3 ply = energy::orthotropic_membrane(2500.0, 100.0, 0.25, 50.0, 1.0);
  const energy::LaminateStiffness l =
      energy::laminate(ply, {{0.5, 0.03}, {-0.9, 0.04}, {0.2, 0.06}, {-0.9, 0.04}, {0.5, 0.03}});
  CHECK(std::abs(l.membrane(0, 2)) > 0.01 * l.membrane(0, 0));
  CHECK(std::abs(l.bending(1, 2)) > 0.01 * l.bending(0, 0));
  CHECK(l.coupling.norm() < 1e-12 * l.membrane.norm());
  const mesh::SurfaceMesh flat(square(Pattern::jittered, 6)), curved(curved_shell());
  for (const auto bending : {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle})
    for (const bool supported : {false, true}) {
      CAPTURE(static_cast<int>(bending));
      CAPTURE(supported);
      system::ModelInput input = input_for(bending, energy::MembraneOperator::six_node_corrected, supported);
      input.materials[0].membrane = l.membrane;
      input.materials[0].bending = l.bending;
      check_derivatives(curved, input);
      if (!supported) check_derivatives(flat, input);
    }
}

TEST_CASE("follower pressure and follower moment have their full stiffness") {
  const mesh::SurfaceMesh curved(curved_shell());
  for (const auto kind : {system::Load::Kind::follower_pressure, system::Load::Kind::follower_moment}) {
    system::ModelInput input = input_for(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node, true);
    system::Load follower;
    follower.kind = kind;
    follower.magnitude = 40.0;  // as large as the shell's own forces, so that an error would show
    follower.group = kind == system::Load::Kind::follower_moment ? "bottom" : "";
    input.loads.push_back(follower);
    check_derivatives(curved, input);
  }
}

TEST_CASE("a rigid motion costs nothing, however large") {
  const mesh::SurfaceMesh mesh(curved_shell());
  for (const auto& [bending, membrane] :
       {std::pair{energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node},
        std::pair{energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected},
        std::pair{energy::BendingOperator::edge_angle, energy::MembraneOperator::six_node_corrected}}) {
    system::Model model(PETSC_COMM_WORLD, mesh, input_for(bending, membrane, false));
    model.conditions().set_load_factor(0.0);
    const Eigen::AngleAxisd turn(2.0, Vec3(1.0, 2.0, -0.5).normalized());
    petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector();
    set_displacement(model, a, [&](Index v) {
      return Vec3(turn * mesh.positions()[v] + Vec3(3.0, -1.0, 2.0) - mesh.positions()[v]);
    });
    model.residual(a, r);
    CHECK(norm(r) < 1e-10);
    CHECK(std::abs(model.energy(a)) < 1e-11);
  }
}

TEST_CASE("differences of energies near the state they are counted from are not lost in round-off") {
  // A fine square rolled up and far away: stiff bending forces times displacements nearly cancel in its energy.
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 40));
  system::Model model(PETSC_COMM_WORLD, mesh,
                      input_for(energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node, false));
  petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector(),
                   moved = model.dofs().create_vector(), r = model.dofs().create_vector();
  set_displacement(model, a, [&](Index v) {
    const Vec3& x = mesh.positions()[v];
    return Vec3(Vec3(std::sin(3.0 * x[0]) / 3.0, x[1], (1.0 - std::cos(3.0 * x[0])) / 3.0) - x + Vec3(5.0, -3.0, 4.0));
  });
  set_displacement(model, d, [&](Index v) {
    const Vec3& x = mesh.positions()[v];
    return Vec3(1e-8 * Vec3(x[1], -x[0], 1.0 + x[0] * x[1]));
  });
  VOILE_PETSC(VecWAXPY(moved, 1.0, d, a));
  model.residual(a, r);
  const double expected = dot(r, d);
  const double lost = std::abs(model.energy(moved) - model.energy(a) - expected);
  model.potential().count_from(a);
  const double kept = std::abs(model.energy(moved) - model.energy(a) - expected);
  CHECK(lost > std::abs(expected));
  CHECK(kept < 1e-4 * std::abs(expected));
}

TEST_CASE("the projected tangent keeps the tensile principal force alone") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 4));
  system::ModelInput input;
  input.materials = {isotropic(100.0, 0.0, 0.1, 1.0)};
  const double thickness = 0.1, young = 100.0, turned = 0.5;
  const Mat3 turn = Eigen::AngleAxisd(turned, Vec3::UnitZ()).toRotationMatrix();
  for (const auto membrane : {energy::MembraneOperator::cst, energy::MembraneOperator::six_node,
                              energy::MembraneOperator::six_node_corrected})
    for (const std::pair<double, double>& strains :
         {std::pair{0.1, 0.05}, std::pair{0.1, -0.05}, std::pair{-0.1, 0.05}, std::pair{-0.1, -0.05}}) {
      const double first = strains.first, second = strains.second;
      CAPTURE(static_cast<int>(membrane));
      CAPTURE(first);
      CAPTURE(second);
      input.element.membrane = membrane;
      system::Model model(PETSC_COMM_WORLD, mesh, input);
      petsc::VecHandle a = model.dofs().create_vector(), w = model.dofs().create_vector(),
                       k = model.dofs().create_vector();
      // Stretched along axes turned in the plane; Green strains e (1 + e/2), forces E t times that.
      const Vec3 stretch(first, second, 0.0);
      set_displacement(model, a, [&](Index v) {
        return Vec3(turn * stretch.asDiagonal() * turn.transpose() * mesh.positions()[v]);
      });
      model.assemble_tangent(a, {.kind = energy::Tangent::positive});
      for (const bool along_first : {true, false}) {
        const Vec3 axis = turn.col(along_first ? 0 : 1);
        const double e = along_first ? first : second, force = young * thickness * e * (1.0 + 0.5 * e);
        set_displacement(model, w, [&](Index v) { return Vec3(axis.dot(mesh.positions()[v]) * Vec3::UnitZ()); });
        VOILE_PETSC(MatMult(model.tangent().matrix(), w, k));
        CHECK(dot(w, k) == relative(std::max(force, 0.0)).epsilon(1e-10).scale(1.0));
      }
    }
}

TEST_CASE("the projected tangent is positive where the exact one is not") {
  // A flat square compressed in its plane: buckling modes make the exact tangent indefinite.
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 6));
  system::ModelInput input;
  input.materials = {isotropic(100.0, 0.3, 0.01)};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector(), d = model.dofs().create_vector(),
                   kd = model.dofs().create_vector();
  set_displacement(model, a, [&](Index v) { return Vec3(-0.05 * mesh.positions()[v][0], 0.0, 0.0); });
  set_displacement(model, d, [&](Index v) { return Vec3(0.0, 0.0, std::sin(3.0 * mesh.positions()[v][0])); });
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  VOILE_PETSC(MatMult(model.tangent().matrix(), d, kd));
  CHECK(dot(kd, d) < 0.0);
  model.assemble_tangent(a, {.kind = energy::Tangent::positive});
  VOILE_PETSC(MatMult(model.tangent().matrix(), d, kd));
  CHECK(dot(kd, d) > 0.0);
}

}  // namespace test_derivatives

// Clamps whose slope turns with them.
#include <doctest/doctest.h>

#include <utility>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "solve/load_path.hpp"
#include "test_following.hpp"
#include "test_problems.hpp"
#include "test_relative.hpp"

namespace test_turning {

using namespace voile;
using namespace voile::testing;
using Kind = system::Support::Kind;

namespace {

/// Turns at unit speed about an oblique axis through a point off the sheet, and moves along.
struct RigidMotion {
  Vec3 axis = Vec3(0.3, 1.0, -0.2).normalized(), centre = Vec3(-0.4, 0.2, 0.3);
  [[nodiscard]] Mat3 rotation(double t) const { return Mat3(Eigen::AngleAxisd(t, axis)); }
  [[nodiscard]] Vec3 displacement(const Vec3& x, double t) const {
    return rotation(t) * (x - centre) + centre - x + t * Vec3(0.5, -0.3, 0.2);
  }
  void drive(system::Support& s) const {
    s.motion = [m = *this](const Vec3& x, double t) { return m.displacement(x, t); };
    s.rotation = [m = *this](double t) { return m.rotation(t); };
  }
};

mesh::MeshData sheet_of(bool curved) {
  mesh::MeshData d = grid(8, 4, true, 0.15, 5);
  add_square_groups(d);
  return mapped(d, [&](const Vec3& x) {
    return curved ? Vec3(2.0 * std::sin(x[0]), x[1], 2.0 * std::cos(x[0])) : Vec3(2.0 * x[0], x[1], 0.0);
  });
}

system::ModelInput input(const RigidMotion& motion, energy::ElementOptions element = {}) {
  system::ModelInput in;
  in.element = element;
  in.materials = {isotropic(1e6, 0.3, 0.05)};
  in.supports = {support("left", Kind::clamped)};
  motion.drive(in.supports[0]);
  in.motion_by_load = true;
  return in;
}

}  // namespace

TEST_CASE("a clamp that turns takes its sheet along as a rigid body, without force and energy") {
  const RigidMotion motion;
  for (const bool curved : {false, true})
    for (const auto& choice :
         {std::pair{energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node},
          std::pair{energy::BendingOperator::six_node, energy::MembraneOperator::six_node},
          std::pair{energy::BendingOperator::edge_angle, energy::MembraneOperator::six_node},
          std::pair{energy::BendingOperator::edge_slope, energy::MembraneOperator::six_node_corrected}}) {
      const energy::MembraneOperator membrane = choice.second;
      CAPTURE(curved);
      CAPTURE(static_cast<int>(membrane));
      const mesh::SurfaceMesh mesh(sheet_of(curved));
      energy::ElementOptions element;
      element.bending = choice.first;
      element.membrane = membrane;
      system::Model model(PETSC_COMM_WORLD, mesh, input(motion, element));
      petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector(),
                       k = model.dofs().create_vector();
      for (const double angle : {0.0, 0.7, 2.5, 0.7}) {
        model.conditions().set_load_factor(angle);
        set_displacement(model, a, [&](Index v) { return motion.displacement(mesh.positions()[v], angle); });
        model.residual(a, r);
        model.potential().constant().multiply_bending(a, k);
        CHECK(norm(r) < 1e-9 * (norm(k) + 1e6 * 0.05));
        CHECK(std::abs(model.energy(a)) < 1e-9 * (std::abs(dot(k, a)) + 1.0));
        const system::TriangleFields fields = model.triangle_fields(a);
        for (const double kappa : fields.curvature) CHECK(std::abs(kappa) < 1e-8);
      }
    }
}

TEST_CASE("with a turned clamp the tangent is the derivative of the residual, and that of the energy") {
  const RigidMotion motion;
  const mesh::SurfaceMesh mesh(sheet_of(true));
  system::Model model(PETSC_COMM_WORLD, mesh, input(motion));
  model.conditions().set_load_factor(0.6);
  petsc::VecHandle a = model.dofs().create_vector(), w = model.dofs().create_vector(),
                   kw = model.dofs().create_vector(), x = model.dofs().create_vector(),
                   up = model.dofs().create_vector(), down = model.dofs().create_vector();
  set_displacement(model, a,
                   [&](Index v) { return Vec3(motion.displacement(mesh.positions()[v], 0.6) + noise(0.02, 3)(v)); });
  model.conditions().enforce(a);
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  set_displacement(model, w, noise(1.0, 2));
  model.dofs().clear_fixed(w);
  VOILE_PETSC(MatMult(model.tangent().matrix(), w, kw));
  const double h = 1e-6;
  VOILE_PETSC(VecWAXPY(x, h, w, a));
  model.residual(x, up);
  const double energy_up = model.energy(x);
  VOILE_PETSC(VecWAXPY(x, -h, w, a));
  model.residual(x, down);
  const double energy_down = model.energy(x);
  VOILE_PETSC(VecAXPY(up, -1.0, down));
  VOILE_PETSC(VecScale(up, 0.5 / h));
  VOILE_PETSC(VecAXPY(up, -1.0, kw));
  CHECK(norm(up) < 1e-5 * norm(kw));
  model.residual(a, down);
  CHECK((energy_up - energy_down) / (2.0 * h) == relative(dot(down, w)).epsilon(1e-6));
  // Counted from another state the energy is the same but for round-off, and so after the clamp was elsewhere.
  const double before = model.energy(a);
  model.potential().count_from(x);
  CHECK(model.energy(a) == relative(before).epsilon(1e-9));
  model.conditions().set_load_factor(0.1);
  model.conditions().set_load_factor(0.6);
  CHECK(model.energy(a) == relative(before).epsilon(1e-9));
}

namespace {

struct Arc {
  double off, energy, force;  ///< largest distance from the circle [m], energy [J], force at the end [N]
};

/// A strip of length 2 between clamps, one of which turns by `total` and goes along the arc: nothing but a moment acts.
Arc bend_to_arc(int cells, double total, double length, double width, const energy::Material& material) {
  mesh::MeshData d = grid(cells, 2, true, 0.0);
  add_square_groups(d);
  const mesh::SurfaceMesh mesh(mapped(d, [&](const Vec3& x) { return Vec3(length * x[0], width * x[1], 0.0); }));
  const auto arc = [&](double s, double angle) {
    if (angle < 1e-9) return Vec3(s, 0.0, 0.0);
    const double radius = length / angle;
    return Vec3(radius * std::sin(s / radius), 0.0, radius * (1.0 - std::cos(s / radius)));
  };
  system::ModelInput in;
  in.materials = {material};
  in.supports = {support("left", Kind::clamped), support("right", Kind::clamped)};
  in.supports[1].rotation = [&](double t) { return Mat3(Eigen::AngleAxisd(-total * t, Vec3::UnitY())); };
  in.supports[1].motion = [&](const Vec3& x, double t) {
    return Vec3(arc(length, total * t) + Vec3(0.0, x[1], 0.0) - x);
  };
  in.motion_by_load = true;
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector();
  solve::StaticOptions options;
  options.initial_step = options.max_step = 0.125;
  solve::LoadPath path(model, options);
  REQUIRE(follow_from(state_of(a), path).completed);
  Arc result{};
  const std::vector<Vec3> u = per_vertex(model, a);
  for (std::size_t v = 0; v < u.size(); ++v) {
    const Vec3& x = mesh.positions()[v];
    result.off = std::max(result.off, (x + u[v] - arc(x[0], total) - Vec3(0.0, x[1], 0.0)).norm());
  }
  const system::Energies e = system::energies(model, a);
  result.energy = e.membrane + e.bending;
  model.unbalanced_force(a, f);
  Vec3 end = Vec3::Zero();
  const std::vector<Vec3> forces = per_vertex(model, f);
  for (Index v : mesh.group("right").vertices) end += forces[static_cast<std::size_t>(v)];
  result.force = end.norm();
  return result;
}

}  // namespace

TEST_CASE("a strip whose clamps turn against each other becomes an arc of a circle") {
  const double total = 2.0, length = 2.0, width = 0.25, thickness = 0.02, young = 1e6;
  const energy::Material material = isotropic(young, 0.0, thickness);
  const double moment = young * std::pow(thickness, 3) / 12.0 * width * total / length;
  const Arc coarse = bend_to_arc(16, total, length, width, material),
            fine = bend_to_arc(32, total, length, width, material);
  MESSAGE("off " << coarse.off << ", " << fine.off << "; energy " << coarse.energy / (0.5 * moment * total) << ", "
                 << fine.energy / (0.5 * moment * total) << "; force " << coarse.force * length / moment << ", "
                 << fine.force * length / moment);
  CHECK(fine.off < 2e-3 * length);
  CHECK(fine.energy == relative(0.5 * moment * total).epsilon(0.01));
  // Chords are corrected to the fourth power of the cell: what force is left is that of the steps.
  CHECK(coarse.force < 0.005 * moment / length);
  CHECK(fine.force < 0.005 * moment / length);
}

TEST_CASE("clamps: products with the bending stiffness are those with its matrix, also after a turn") {
  const mesh::SurfaceMesh mesh(sheet_of(false));
  system::Model model(PETSC_COMM_WORLD, mesh, input(RigidMotion{}));
  const petsc::VecHandle x = model.dofs().create_vector(), y = model.dofs().create_vector(),
                         z = model.dofs().create_vector();
  PetscInt begin = 0, end = 0;
  VOILE_PETSC(VecGetOwnershipRange(x, &begin, &end));
  for (PetscInt i = begin; i < end; ++i) VOILE_PETSC(VecSetValue(x, i, 1e-3 * std::sin(1.0 * i * i), INSERT_VALUES));
  VOILE_PETSC(VecAssemblyBegin(x));
  VOILE_PETSC(VecAssemblyEnd(x));
  for (const double load : {0.0, 0.7}) {
    double size = 0.0, off = 0.0;
    model.conditions().set_load_factor(load);
    model.residual(x, y);
    model.potential().constant().multiply_bending(x, y);
    system::BlockMatrix whole = model.potential().constant().base().twin();
    const system::BlockMatrix::Values values = whole.open();
    whole.clear();
    model.potential().constant().bending().add_to(whole, values, 0.5);
    model.potential().constant().bending().add_to(whole, values, 0.5);
    whole.close();
    VOILE_PETSC(MatMult(whole.mat(), x, z));
    VOILE_PETSC(VecNorm(z, NORM_INFINITY, &size));
    VOILE_PETSC(VecAXPY(z, -1.0, y));
    VOILE_PETSC(VecNorm(z, NORM_INFINITY, &off));
    CHECK(off < 1e-12 * size);
  }
}

}  // namespace test_turning

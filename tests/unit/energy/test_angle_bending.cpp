// Bending by the angles at edges: one angle, and sheets that bend by them.
#include "energy/angle_bending.hpp"

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "../test_model_kit.hpp"
#include "base/decompositions.hpp"

namespace test_angle_bending {

using namespace voile;
using namespace voile::testing;

namespace {

using energy::BendingOperator;
using Kind = system::Support::Kind;

system::ModelInput bending_by(BendingOperator op) {
  system::ModelInput in;
  in.element.bending = op;
  energy::Material m = isotropic(100.0, 0.3, 0.1, 1.0);
  m.bending(0, 2) = m.bending(2, 0) = 0.1 * m.bending(0, 0);
  m.direction = Vec3(1.0, 0.2, 0.1);
  in.materials = {m};
  return in;
}

/// Energy of bending of displaced vertices.
double bending_energy(const mesh::SurfaceMesh& mesh, const system::ModelInput& in,
                      const std::function<Vec3(Index)>& u) {
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector();
  set_displacement(model, a, u);
  return system::energies(model, a).bending;
}

/// Cells of aspect 8 moved at random, where most patches are fitted over more neighbours.
mesh::MeshData slivers() {
  return mapped(square(Pattern::jittered, 8), [](const Vec3& x) { return Vec3(x[0], 0.125 * x[1], 0.0); });
}

}  // namespace

TEST_CASE("the angle at an edge has its sign, and derivatives that agree with differences") {
  for (const double angle : {-2.9, -1.0, -1e-3, 0.4, 2.0, 3.1}) {
    CAPTURE(angle);
    const Vec3 shift(3.0, -2.0, 5.0);
    const energy::EdgePoints x{shift, shift + Vec3(2.0, 0.0, 0.0), shift + Vec3(0.3, 1.1, 0.0),
                               shift + Vec3(2.4, -0.7 * std::cos(angle), 0.7 * std::sin(angle))};
    CHECK(energy::edge_angle(x) == relative(angle).epsilon(1e-12));
    const energy::EdgePoints slopes = energy::edge_angle_slopes(x);
    const energy::EdgeAngleCurvature second = energy::edge_angle_curvature(x);
    const double h = 1e-5;
    for (std::size_t j = 0; j < 4; ++j)
      for (int r = 0; r < 3; ++r) {
        energy::EdgePoints up = x, down = x;
        up[j][r] += h;
        down[j][r] -= h;
        CHECK(slopes[j][r] ==
              doctest::Approx((energy::edge_angle(up) - energy::edge_angle(down)) / (2.0 * h)).epsilon(1e-8));
        const energy::EdgePoints above = energy::edge_angle_slopes(up), below = energy::edge_angle_slopes(down);
        for (std::size_t i = 0; i < 4; ++i)
          CHECK((Vec3(second[i][j].col(r)) - (above[i] - below[i]) / (2.0 * h)).norm() < 1e-8);
      }
  }
}

TEST_CASE("a flat sheet bends a little by its angles as with edge_slope, whatever its cells") {
  for (const mesh::MeshData& data : {square(Pattern::jittered, 6), square(Pattern::union_jack, 6),
                                     square(Pattern::split, 6), square(Pattern::gmsh, 6), slivers()})
    for (const bool supported : {false, true}) {
      const mesh::SurfaceMesh mesh(data);
      system::ModelInput in = bending_by(BendingOperator::edge_slope);
      if (supported) in.supports = {support("left", Kind::clamped), support("right", Kind::symmetry)};
      system::Model slope(PETSC_COMM_WORLD, mesh, in);
      in.element.bending = BendingOperator::edge_angle;
      system::Model angle(PETSC_COMM_WORLD, mesh, in);
      const petsc::VecHandle a = slope.dofs().create_vector(), w = slope.dofs().create_vector(),
                             expected = slope.dofs().create_vector(), found = slope.dofs().create_vector();
      const auto random = noise(1.0, 3);
      set_displacement(slope, w, [&](Index v) { return Vec3(0.0, 0.0, random(v)[2]); });
      for (const energy::Tangent kind : {energy::Tangent::exact, energy::Tangent::positive}) {
        slope.assemble_tangent(a, {.kind = kind});
        angle.assemble_tangent(a, {.kind = kind});
        VOILE_PETSC(MatMult(slope.tangent().matrix(), w, expected));
        VOILE_PETSC(MatMult(angle.tangent().matrix(), w, found));
        VOILE_PETSC(VecAXPY(found, -1.0, expected));
        CHECK(norm(expected) > 1e-3);
        CHECK(norm(found) < 1e-9 * norm(expected));
      }
    }
}

TEST_CASE("what happens in the plane bends nothing by angles, on slivers either") {
  for (const mesh::MeshData& data : {square(Pattern::jittered, 6), slivers()}) {
    const mesh::SurfaceMesh mesh(data);
    const auto bent = [&](Index v) {
      const Vec3 x = mesh.positions()[v];
      return Vec3(0.3 * x[0] * x[1] + 0.2 * x[0], -0.2 * x[0] * x[0], 0.0);
    };
    const double charged = bending_energy(mesh, bending_by(BendingOperator::edge_slope), bent);
    CHECK(charged > 1e-5);
    CHECK(std::abs(bending_energy(mesh, bending_by(BendingOperator::edge_angle), bent)) < 1e-9 * charged);
  }
}

TEST_CASE("arcs have their whole curvature by angles, and folds grow with the square of theirs") {
  constexpr int n = 8;
  constexpr double per_cell = 0.5;
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, n));
  // Vertices on a circle that is as long as the sheet: chords are shorter than cells.
  const double radius = 1.0 / (n * per_cell);
  system::Model model(PETSC_COMM_WORLD, mesh, bending_by(BendingOperator::edge_angle));
  const petsc::VecHandle a = model.dofs().create_vector();
  set_displacement(model, a, [&](Index v) {
    const Vec3 x = mesh.positions()[v];
    return Vec3(radius * std::sin(x[0] / radius) - x[0], 0.0, radius * (1.0 - std::cos(x[0] / radius)));
  });
  const system::TriangleFields fields = model.triangle_fields(a);
  if (mpi::rank(PETSC_COMM_WORLD) == 0)
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
      bool inside = true;
      for (const Index v : mesh.triangles()[t])
        for (int k = 0; k < 2; ++k) inside = inside && std::abs(mesh.positions()[v][k] - 0.5) < 0.5 - 1.5 / n;
      if (!inside) continue;
      const Eigen::Map<const Vec3> k(fields.curvature.data() + 3 * static_cast<std::size_t>(t)),
          moment(fields.bending_moment.data() + 3 * static_cast<std::size_t>(t));
      CHECK(k[0] + k[1] == relative(1.0 / radius).epsilon(1e-12));
      CHECK((moment - bending_by(BendingOperator::edge_angle).materials[0].bending * k).norm() < 1e-12 * moment.norm());
    }
  for (const double angle : {0.3, 1.5, -2.8}) {
    const auto folded = [&](Index v) {
      const Vec3 x = mesh.positions()[v] - Vec3(0.5, 0.0, 0.0);
      return x[0] <= 0.0 ? Vec3(0.0, 0.0, 0.0) : Vec3(x[0] * (std::cos(angle) - 1.0), 0.0, x[0] * std::sin(angle));
    };
    const double by_slope = bending_energy(mesh, bending_by(BendingOperator::edge_slope), folded),
                 by_angle = bending_energy(mesh, bending_by(BendingOperator::edge_angle), folded);
    CHECK(by_angle == relative(by_slope * angle * angle / (2.0 - 2.0 * std::cos(angle))).epsilon(1e-10));
  }
}

TEST_CASE("a sheet that is folded at rest twists by angles as the flat one does, across the crease too") {
  using energy::MembraneOperator;
  const auto energy_of = [](BendingOperator op, double crease,
                            MembraneOperator membrane = MembraneOperator::six_node_corrected) {
    const mesh::SurfaceMesh mesh(mapped(square(Pattern::diagonal, 8), [&](const Vec3& x) {
      const double past = std::max(x[0] - 0.5, 0.0);
      return Vec3(std::min(x[0], 0.5) - 0.5 + past * std::cos(crease), x[1], past * std::sin(crease));
    }));
    system::ModelInput in = bending_by(op);
    in.element.membrane = membrane;
    in.materials[0].direction = Vec3(0.0, 1.0, 0.0);  // along the crease, about which it is twisted
    return bending_energy(mesh, in, [&](Index v) {
      const Vec3 x = mesh.positions()[v];
      return Vec3(1e-4 * x[1] * Vec3(x[2], 0.0, -x[0]));
    });
  };
  for (const double crease : {0.5, 1.5, -2.5}) {
    CAPTURE(crease);
    CHECK(energy_of(BendingOperator::edge_angle, crease) ==
          relative(energy_of(BendingOperator::edge_angle, 0.0)).epsilon(1e-6));
    // Vectors also have what one side moves in its plane; beside creases the default element takes angles.
    CHECK(energy_of(BendingOperator::edge_slope, crease, MembraneOperator::six_node) >
          1.02 * energy_of(BendingOperator::edge_slope, 0.0, MembraneOperator::six_node));
    if (std::abs(crease) > energy::ElementOptions{}.crease_angle)
      CHECK(energy_of(BendingOperator::edge_slope, crease) ==
            relative(energy_of(BendingOperator::edge_slope, 0.0)).epsilon(1e-6));
  }
}

TEST_CASE("arcs that have their whole curvature by angles take no term of fourth order from the corrected membrane") {
  const mesh::SurfaceMesh mesh(square(Pattern::diagonal, 12));
  const double radius = 0.25;  // 19 degrees per cell
  const auto rolled = [&](Index v) {
    const Vec3 x = mesh.positions()[v];
    return Vec3(radius * std::sin(x[0] / radius) - x[0], 0.0, radius * (1.0 - std::cos(x[0] / radius)));
  };
  const auto fraction = [&](BendingOperator op) {
    system::ModelInput in = bending_by(op);
    in.element.membrane = energy::MembraneOperator::six_node_corrected;
    in.materials[0].membrane *= 1e-6;  // what is left of the term
    system::Model model(PETSC_COMM_WORLD, mesh, in);
    const petsc::VecHandle a = model.dofs().create_vector();
    set_displacement(model, a, rolled);
    const system::Energies e = system::energies(model, a);
    return e.membrane / e.bending;
  };
  CHECK(fraction(BendingOperator::edge_slope) > 1e-2);
  CHECK(fraction(BendingOperator::edge_angle) < 1e-4);
}

TEST_CASE("the positive tangent of a sheet that bends by its angles has no negative eigenvalue, the exact one has") {
  if (mpi::size(PETSC_COMM_WORLD) > 1) return;  // dense eigenvalues
  const mesh::SurfaceMesh mesh(mapped(square(Pattern::jittered, 5), [](const Vec3& x) {
    return Vec3(x[0], x[1], 0.3 * x[0] * x[0] - 0.2 * x[1] * x[1]);
  }));
  system::ModelInput in = bending_by(BendingOperator::edge_angle);
  in.materials[0].membrane *= 1e-3;  // so that bending is what counts
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  const petsc::VecHandle a = model.dofs().create_vector();
  set_displacement(model, a, noise(0.1, 7));
  model.assemble_tangent(a, {.kind = energy::Tangent::exact});
  const Eigen::VectorXd exact = eigenvalues(dense_tangent(model));
  CHECK(exact[0] < -1e-3 * exact[exact.size() - 1]);
  model.assemble_tangent(a, {.kind = energy::Tangent::positive});
  const Eigen::VectorXd positive = eigenvalues(dense_tangent(model));
  CHECK(positive[0] > -1e-11 * positive[positive.size() - 1]);
}

TEST_CASE("bending by angles is the same on any number of ranks") {
  for (const mesh::MeshData& data : {square(Pattern::jittered, 7), slivers()}) {
    const mesh::SurfaceMesh mesh(data);
    system::ModelInput in = bending_by(BendingOperator::edge_angle);
    in.supports = {support("left", Kind::clamped)};
    system::Model model(PETSC_COMM_WORLD, mesh, in), alone(PETSC_COMM_SELF, mesh, in);
    const petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                           a_alone = alone.dofs().create_vector(), f_alone = alone.dofs().create_vector();
    set_displacement(model, a, noise(0.01, 9));
    set_displacement(alone, a_alone, noise(0.01, 9));
    CHECK(system::energies(model, a).bending == relative(system::energies(alone, a_alone).bending).epsilon(1e-11));
    model.residual(a, f);
    alone.residual(a_alone, f_alone);
    CHECK(relative_difference(per_vertex(model, f), per_vertex(alone, f_alone)) < 1e-11);
  }
}

}  // namespace test_angle_bending

// The same answers on all ranks together as on each one alone.
#include <doctest/doctest.h>

#include "extent.hpp"
#include "solve/load_path.hpp"
#include "test_following.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"

namespace test_rank_consistency {

using namespace voile;
using namespace voile::testing;

namespace {

/// A curved panel of 968 triangles, clamped at one edge, oblique symmetry at another.
mesh::MeshData panel() {
  mesh::MeshData d = grid(22, 22, true, 0.2);
  add_square_groups(d);
  d.groups.push_back({"corner", 0, {23 * 23 - 1}, {}, {}});
  const double c = std::cos(0.6), s = std::sin(0.6);
  return mapped(d, [=](const Vec3& x) {
    const Vec3 y(x[0], x[1], 0.2 * std::cos(1.5 * x[0]) + 0.1 * x[1] * x[1]);
    return Vec3(c * y[0] - s * y[1], s * y[0] + c * y[1], y[2]);
  });
}

system::ModelInput problem(bool follower, energy::MembraneOperator membrane) {
  system::ModelInput input;
  input.element.membrane = membrane;
  input.materials = {isotropic(1e6, 0.3, 0.01, 0.02)};
  input.supports = {support("left", system::Support::Kind::clamped),
                    support("bottom", system::Support::Kind::symmetry)};
  input.supports[0].value = Vec3(0.0, 0.0, 0.02);  // within the symmetry plane, or their common corner would contradict
  input.supports[1].normal = Vec3(-std::sin(0.6), std::cos(0.6), 0.0);
  system::Load gravity, point, pressure;
  gravity.kind = system::Load::Kind::gravity;
  gravity.vector = Vec3(0.0, 0.0, -9.81);
  gravity.constant = true;
  point.kind = system::Load::Kind::point;
  point.group = "corner";
  point.vector = Vec3(0.05, 0.0, -0.25);
  input.loads = {gravity, point};
  pressure.kind = system::Load::Kind::follower_pressure;
  pressure.magnitude = 0.1;
  if (follower) input.loads.push_back(pressure);
  return input;
}

/// Everything that must not depend on the number of ranks.
struct Answer {
  std::vector<double> displacement, unbalanced, product, membrane_force, bending_moment, mass;
  system::Energies energies;
  double energy = 0.0, force_scale = 0.0, area = 0.0;
  int steps = 0;
};

std::vector<double> everywhere(MPI_Comm comm, std::vector<double> values) {
  mpi::broadcast(comm, values);
  return values;
}

Answer answer(MPI_Comm comm, const mesh::SurfaceMesh& mesh, const system::ModelInput& input) {
  system::Model model(comm, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(), x = model.dofs().create_vector();
  solve::LoadPath path(model, {});
  const testing::Ended result = testing::follow_from(testing::state_of(a), path);
  REQUIRE(result.completed);
  Answer r;
  r.steps = result.steps;
  const auto all = [&](Vec v) { return everywhere(comm, model.dofs().gather(v)); };
  r.displacement = all(a);
  model.residual(a, f);
  r.force_scale = model.force_scale();
  model.unbalanced_force(a, f);
  r.unbalanced = all(f);
  r.energies = system::energies(model, a);
  r.energy = model.energy(a);
  r.area = model.discretisation().mean_area() * model.dofs().mesh().triangle_count();
  const system::TriangleFields fields = model.triangle_fields(a);
  r.membrane_force = everywhere(comm, fields.membrane_force);
  r.bending_moment = everywhere(comm, fields.bending_moment);
  // At a rough state, so that the comparison is of the assembly and not of two solutions.
  set_displacement(model, a, noise(0.02, 3));
  set_displacement(model, x, noise(1.0, 5));
  model.assemble_tangent(a, {.kind = energy::Tangent::exact, .mass = 0.3});
  VOILE_PETSC(MatMult(model.tangent().matrix(), x, f));
  r.product = all(f);
  // The mass is the same for all components, so the vertex axes do not matter to it, but gather() would turn it.
  VOILE_PETSC(VecPointwiseMult(f, model.potential().constant().mass(), x));
  r.mass = all(f);
  return r;
}

double relative_difference(const std::vector<double>& p, const std::vector<double>& q) {
  REQUIRE(p.size() == q.size());
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    difference = std::max(difference, std::abs(p[i] - q[i]));
    size = std::max(size, std::abs(q[i]));
  }
  REQUIRE(size > 0.0);
  return difference / size;
}

}  // namespace

TEST_CASE("displacements, reactions, stresses, energies and tangents do not depend on the number of ranks") {
  const Option rtol("-snes_rtol", "1e-12"), stol("-snes_stol", "1e-12");  // as far as round-off lets them
  const mesh::SurfaceMesh mesh(panel());
  REQUIRE(mesh.triangle_count() == 968);
  for (const auto& choice :
       {std::pair{false, energy::MembraneOperator::six_node}, std::pair{true, energy::MembraneOperator::six_node},
        std::pair{true, energy::MembraneOperator::six_node_corrected}}) {
    const bool follower = choice.first;
    const energy::MembraneOperator membrane = choice.second;
    if (extent(false, !follower)) continue;
    CAPTURE(follower);
    CAPTURE(static_cast<int>(membrane));
    const system::ModelInput input = problem(follower, membrane);
    const Answer alone = answer(MPI_COMM_SELF, mesh, input), together = answer(PETSC_COMM_WORLD, mesh, input);
    double largest = 0.0;
    for (double u : alone.displacement) largest = std::max(largest, std::abs(u));
    CHECK(largest > 0.3);  // a third of the panel's side
    CHECK(alone.steps == together.steps);
    CHECK(relative_difference(together.displacement, alone.displacement) < 1e-9);
    CHECK(relative_difference(together.unbalanced, alone.unbalanced) < 1e-9);
    CHECK(relative_difference(together.membrane_force, alone.membrane_force) < 1e-9);
    CHECK(relative_difference(together.bending_moment, alone.bending_moment) < 1e-9);
    CHECK(together.energies.membrane == relative(alone.energies.membrane).epsilon(1e-9));
    CHECK(together.energies.bending == relative(alone.energies.bending).epsilon(1e-9));
    CHECK(together.energies.external == relative(alone.energies.external).epsilon(1e-9));
    CHECK(together.energy == relative(alone.energy).epsilon(1e-9));
    CHECK(together.force_scale == relative(alone.force_scale).epsilon(1e-9));
    CHECK(together.area == relative(alone.area).epsilon(1e-13));
    CHECK(relative_difference(together.product, alone.product) < 1e-12);
    CHECK(relative_difference(together.mass, alone.mass) < 1e-13);
  }
}

TEST_CASE("models on different communicators live side by side") {
  // A rank may solve alone while others wait: nothing in a model may be collective on the world.
  const mesh::SurfaceMesh mesh(panel());
  if (mpi::rank(PETSC_COMM_WORLD) == 0) {
    system::Model model(MPI_COMM_SELF, mesh, problem(false, energy::MembraneOperator::six_node));
    petsc::VecHandle a = model.dofs().create_vector();
    model.conditions().set_load_factor(0.1);
    solve::Newton newton(model);
    CHECK(newton.step(a).converged);
    CHECK(norm(a) > 0.0);
  }
  CHECK(mpi::sum(PETSC_COMM_WORLD, 1L) == mpi::size(PETSC_COMM_WORLD));
}

}  // namespace test_rank_consistency

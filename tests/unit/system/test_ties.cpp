// Springs between two vertices: a term of the potential like any other, on any number of ranks.
#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>

#include <cmath>

#include "base/decompositions.hpp"
#include "energy/spring.hpp"
#include "solve/newton.hpp"
#include "system/rigid_motions.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_ties {

using namespace voile;
using namespace voile::testing;
using SupportKind = system::Support::Kind;

namespace {

/// Two unit squares side by side, `gap` apart; groups lower_right and upper_left face each other.
mesh::MeshData two_sheets(int cells, double gap) {
  mesh::MeshData all = square(Pattern::jittered, cells);
  all.groups.clear();
  const auto half = static_cast<Index>(all.positions.size());
  const std::size_t triangles = all.triangles.size();
  for (Index v = 0; v < half; ++v) all.positions.emplace_back(all.positions[v] + Vec3(1.0 + gap, 0.0, 0.0));
  for (std::size_t t = 0; t < triangles; ++t) {
    const mesh::Triangle w = all.triangles[t];
    all.triangles.push_back({w[0] + half, w[1] + half, w[2] + half});
  }
  const auto group = [&](const std::string& name, Index from, double x) {
    mesh::Group g{name, 0, {}, {}, {}};
    for (Index v = from; v < from + half; ++v)
      if (std::abs(all.positions[v][0] - x) < 1e-12) g.vertices.push_back(v);
    all.groups.push_back(g);
  };
  group("far_left", 0, 0.0);
  group("right", 0, 1.0);
  group("left", half, 1.0 + gap);
  group("far_right", half, 2.0 + gap);
  mesh::Group first{"first", 0, {}, {}, {}};
  for (Index v = 0; v < half; ++v) first.vertices.push_back(v);
  all.groups.push_back(first);
  return all;
}

system::Spring tie(double stiffness, double length = std::nan("")) {
  system::Spring s;
  s.kind = system::Spring::Kind::pair;
  s.group = "right";
  s.to = "left";
  s.stiffness = stiffness;
  s.length = length;
  return s;
}

system::ModelInput input(const std::vector<system::Spring>& springs) {
  system::ModelInput in;
  in.materials = {isotropic(100.0, 0.3, 0.1, 1.0)};
  in.supports = {support("far_left", SupportKind::hinged)};
  in.springs = springs;
  return in;
}

}  // namespace

TEST_CASE("a spring between two points: force and tangent are derivatives of its energy") {
  for (const double length : {0.0, 0.5, 2.0}) {
    CAPTURE(length);
    energy::SpringTerm spring;
    spring.add({0, 1}, 3.0, length, true);
    std::array<Vec3, 2> x{Vec3(0.1, 0.2, -0.3), Vec3(0.7, -0.4, 0.5)};
    const auto at = [&](energy::Tangent kind) { return energy::Configuration{x.data(), nullptr, nullptr, kind}; };
    const auto exact = at(energy::Tangent::exact);
    const auto forces = [&] {
      std::array<Vec3, 2> f;
      spring.gradient(0, exact, [&](int a, const Vec3& g) { f[static_cast<std::size_t>(a)] = g; });
      return f;
    };
    CHECK(spring.energy(0, exact) == relative(1.5 * std::pow((x[1] - x[0]).norm() - length, 2)).epsilon(1e-14));
    std::array<std::array<Mat3, 2>, 2> k, positive;
    spring.hessian(0, exact, [&](int a, int b, const Mat3& m) { k[a][b] = m; });
    spring.hessian(0, at(energy::Tangent::positive), [&](int a, int b, const Mat3& m) { positive[a][b] = m; });
    const double h = 1e-5;
    for (std::size_t p = 0; p < 2; ++p)
      for (int c = 0; c < 3; ++c) {
        const Vec3 step = h * Vec3::Unit(c);
        x[p] += step;
        const double up = spring.energy(0, exact);
        const auto force_up = forces();
        x[p] -= 2.0 * step;
        const double down = spring.energy(0, exact);
        const auto force_down = forces();
        x[p] += step;
        CHECK((up - down) / (2.0 * h) == relative(forces()[p][c]).epsilon(1e-7));
        for (std::size_t q = 0; q < 2; ++q)
          CHECK(((force_up[q] - force_down[q]) / (2.0 * h) - k[q][p].col(c)).norm() < 1e-7);
      }
    CHECK(eigenvalues(Eigen::MatrixXd(positive[0][0])).minCoeff() >= -1e-12);
    // In compression the sides are what makes the exact tangent indefinite.
    CHECK((eigenvalues(Eigen::MatrixXd(k[0][0])).minCoeff() < 0.0) == (length > (x[1] - x[0]).norm()));
  }
}

TEST_CASE("ties in a model: the residual is the derivative of the energy, the tangent that of the residual") {
  const mesh::SurfaceMesh mesh(two_sheets(5, 0.1));
  system::Model model(PETSC_COMM_WORLD, mesh, input({tie(7.0, 0.05)}));
  const auto vector = [&] { return model.dofs().create_vector(); };
  petsc::VecHandle a = vector(), d = vector();
  set_displacement(model, a, noise(0.02, 3));
  set_displacement(model, d, noise(1.0, 4));
  model.conditions().enforce(a);
  model.dofs().clear_fixed(d);
  check_potential(model, a, d);
  CHECK(system::energies(model, a).springs > 0.0);
}

TEST_CASE("ties pull sheets together as springs in series do") {
  const double gap = 0.1, stiffness = 2.0, force = 0.3;
  const int cells = 4;
  const mesh::SurfaceMesh mesh(two_sheets(cells, gap));
  system::ModelInput in = input({tie(stiffness)});
  in.materials = {isotropic(1e6, 0.0, 0.1, 1.0)};  // as good as rigid
  system::Support guide = support("far_right", SupportKind::displacement);
  guide.components = {false, true, true};
  system::Support pulled = support("left", SupportKind::displacement);
  pulled.components = {false, true, true};
  in.supports.push_back(guide);
  in.supports.push_back(pulled);
  in.supports.push_back(support("right", SupportKind::hinged));
  in.loads = {load(system::Load::Kind::point, "far_right", Vec3(force, 0.0, 0.0))};
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  model.conditions().set_load_factor(1.0);
  petsc::VecHandle a = model.dofs().create_vector();
  solve::Newton newton(model);
  const solve::NewtonResult n = newton.step(a);
  CAPTURE(n.reason);
  REQUIRE(n.converged);
  // As many vertices are pulled as there are ties.
  const std::vector<Vec3> u = per_vertex(model, a);
  for (Index v : mesh.group("left").vertices) CHECK(u[v][0] == relative(force / stiffness).epsilon(1e-4));
  CHECK(system::energies(model, a).springs == relative((cells + 1) * 0.5 * force * force / stiffness).epsilon(1e-4));
}

TEST_CASE("ties hold pieces to each other, and what they join is checked") {
  const mesh::SurfaceMesh mesh(two_sheets(4, 0.1));
  const system::Constraints held = system::resolve_supports(mesh, {support("first", SupportKind::hinged)});
  CHECK(system::free_pieces(mesh, held).size() == 1);
  CHECK(system::free_pieces(mesh, held, {tie(1.0, 0.0)}).size() == 1);  // a hinge along the tied edges
  CHECK(system::free_pieces(mesh, held, {tie(1.0, 0.0)}).front().motions() == 1);
  // Parallel bars hold one component and the turns that change it.
  CHECK(system::free_pieces(mesh, held, {tie(1.0)}).front().translations == 2);
  system::Spring self = tie(1.0);
  self.to = "right";
  CHECK_THROWS_AS((void)system::pairs_of(mesh, self), UserError);
  self.to = "nowhere";
  CHECK_THROWS_AS((void)system::pairs_of(mesh, self), UserError);
  CHECK(system::pairs_of(mesh, tie(1.0)).size() == 5);
}

}  // namespace test_ties

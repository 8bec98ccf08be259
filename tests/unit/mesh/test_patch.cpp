// Patch tests of bending and membrane on good and ugly meshes, and the modes that must cost nothing.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <set>

#include "base/decompositions.hpp"
#include "energy/curvature.hpp"
#include "test_model_kit.hpp"

namespace test_patch {

using namespace voile;
using namespace voile::testing;

namespace {

constexpr std::array patterns{Pattern::diagonal, Pattern::union_jack, Pattern::jittered, Pattern::gmsh, Pattern::split};

/// Vertices at least `rings` rings away from the boundary.
std::vector<char> interior(const mesh::SurfaceMesh& mesh, int rings) {
  std::vector<char> inside(static_cast<std::size_t>(mesh.vertex_count()), 1);
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s)
      if (mesh.neighbour(t, s) == no_index)
        for (int k = 1; k < 3; ++k) inside[mesh.triangles()[t][(s + k) % 3]] = 0;
  for (int r = 1; r < rings; ++r) {
    const std::vector<char> before = inside;
    for (const mesh::Triangle& v : mesh.triangles())
      if (!before[v[0]] || !before[v[1]] || !before[v[2]])
        for (Index i : v) inside[i] = 0;
  }
  return inside;
}

/// Puts all vertices of the outer rings into a group.
void add_outer_group(mesh::MeshData& d, int rings) {
  mesh::Group g{"outer", 0, {}, {}, {}};
  const std::vector<char> inside = interior(mesh::SurfaceMesh(d), rings);
  for (Index v = 0; v < static_cast<Index>(inside.size()); ++v)
    if (!inside[v]) g.vertices.push_back(v);
  d.groups.push_back(g);
}

/// Error of the discrete solution when the outer vertices follow the exact state `a`: K^-1 r over the largest |a|.
double solution_error(system::Model& model, Vec a, Vec force, Vec tangent_at) {
  petsc::VecHandle error = model.dofs().create_vector(), r = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(force, r));
  {
    const petsc::WriteArray values(r);
    const Index first = model.dofs().partition().owned_begin(mpi::rank(model.dofs().comm()));
    for (const auto& [v, s] : model.discretisation().constraints().vertices)
      if (model.dofs().partition().vertex_rank[v] == mpi::rank(model.dofs().comm()))
        for (int k = 0; k < 3; ++k) values[3 * (model.dofs().partition().row_of[v] - first) + k] = 0.0;
  }
  model.assemble_tangent(tangent_at, {.kind = energy::Tangent::exact});
  solve_linear(model, r, error);
  double largest = 0.0, scale = 0.0;
  VOILE_PETSC(VecNorm(error, NORM_INFINITY, &largest));
  VOILE_PETSC(VecNorm(a, NORM_INFINITY, &scale));
  REQUIRE(scale > 0.1);
  return largest / scale;
}

system::ModelInput held_outside(const energy::Material& material) {
  system::ModelInput input;
  input.materials = {material};
  input.supports = {support("outer", system::Support::Kind::hinged)};
  return input;
}

energy::Material anisotropic() {
  energy::Material m;
  m.membrane << 4.0, 1.0, 0.3, 1.0, 2.0, -0.2, 0.3, -0.2, 1.0;
  m.bending << 3.0, 0.5, 0.4, 0.5, 2.0, 0.1, 0.4, 0.1, 0.8;
  m.direction = Vec3(1.0, 0.4, 0.0);
  return m;
}

double bending_patch_error(Pattern p, energy::BendingOperator op, const energy::Material& material, const Vec3& k) {
  mesh::MeshData data = square(p, 12);
  add_outer_group(data, 3);
  const mesh::SurfaceMesh mesh(data);
  system::ModelInput input = held_outside(material);
  input.element.bending = op;
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector(),
                   flat = model.dofs().create_vector();
  set_displacement(model, a, [&](Index v) {
    const Vec3 x = mesh.positions()[v];
    return Vec3(0.0, 0.0, 0.5 * k[0] * x[0] * x[0] + 0.5 * k[1] * x[1] * x[1] + 0.5 * k[2] * x[0] * x[1]);
  });
  model.potential().constant().multiply_bending(a, f);
  // The plate problem is linear: its tangent is that of the flat state.
  return solution_error(model, a, f, flat);
}

}  // namespace

TEST_CASE("edge_slope passes the constant-curvature patch test on every mesh") {
  for (const Pattern p : patterns)
    for (const Vec3& k : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
      CAPTURE(name_of(p));
      CHECK(bending_patch_error(p, energy::BendingOperator::edge_slope, isotropic(1.0, 0.3, 1.0), k) < 1e-12);
      CHECK(bending_patch_error(p, energy::BendingOperator::edge_slope, anisotropic(), k) < 1e-12);
    }
}

TEST_CASE("six_node passes it on regular meshes and fails on others") {
  const auto error = [&](Pattern p) {
    return bending_patch_error(p, energy::BendingOperator::six_node, isotropic(1.0, 0.3, 1.0), Vec3(1, 0, 0));
  };
  CHECK(error(Pattern::diagonal) < 1e-12);
  CHECK(error(Pattern::union_jack) > 5e-3);
  CHECK(error(Pattern::jittered) > 1e-3);
  CHECK(error(Pattern::gmsh) > 1e-4);
}

TEST_CASE("both operators reproduce the curvature of a quadratic in the interior") {
  for (const Pattern p : patterns)
    for (const auto op : {energy::BendingOperator::edge_slope, energy::BendingOperator::six_node}) {
      CAPTURE(name_of(p));
      const mesh::SurfaceMesh mesh(square(p, 10));
      const std::vector<energy::Material> materials{isotropic(1.0, 0.3, 1.0)};
      const mesh::PatchMesh patches(mesh, {});
      energy::ElementOptions options;
      options.bending = op;
      const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), options);
      energy::CurvatureBuilder builder(sheet);
      const std::vector<char> inside = interior(mesh, 3);
      double worst = 0.0;
      int count = 0;
      for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const mesh::Triangle& v = mesh.triangles()[t];
        if (!inside[v[0]] || !inside[v[1]] || !inside[v[2]]) continue;
        const energy::CurvatureOperator k = builder.build(t);
        Vec3 kappa = Vec3::Zero();
        for (std::size_t i = 0; i < k.points.size(); ++i) {
          const Vec3 x = mesh.positions()[k.points[i]];
          kappa += k.weights.col(static_cast<Eigen::Index>(i)) *
                   (1.5 * x[0] * x[0] - 0.5 * x[1] * x[1] + 0.75 * x[0] * x[1] + 3.0 * x[0] - 1.0);
        }
        worst = std::max(worst, (kappa - Vec3(3.0, -1.0, 1.5)).norm());
        ++count;
      }
      CHECK(count > 10);
      CHECK(worst < 1e-10);
    }
}

TEST_CASE("membranes pass the constant-strain patch test on every mesh") {
  for (const Pattern p : patterns)
    for (const auto op : {energy::MembraneOperator::cst, energy::MembraneOperator::six_node,
                          energy::MembraneOperator::six_node_corrected}) {
      CAPTURE(name_of(p));
      mesh::MeshData data = square(p, 12);
      add_outer_group(data, 2);
      const mesh::SurfaceMesh mesh(data);
      system::ModelInput input = held_outside(anisotropic());
      input.element.membrane = op;
      system::Model model(PETSC_COMM_WORLD, mesh, input);
      petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector();
      Mat3 gradient;  // a finite stretch, shear and rotation
      gradient << 1.3, 0.3, 0.0, -0.1, 1.2, 0.0, 0.4, -0.2, 0.0;
      set_displacement(model, a, [&](Index v) { return Vec3(gradient * mesh.positions()[v] - mesh.positions()[v]); });
      model.residual(a, f);
      CHECK(solution_error(model, a, f, a) < 1e-12);
    }
}

TEST_CASE("a free curved shell has exactly six rigid-body modes and no stress at rest") {
  if (mpi::size(PETSC_COMM_WORLD) > 1) return;  // dense eigenvalues
  for (const auto op :
       {energy::BendingOperator::edge_slope, energy::BendingOperator::edge_angle, energy::BendingOperator::six_node})
    for (const auto membrane : {energy::MembraneOperator::cst, energy::MembraneOperator::six_node,
                                energy::MembraneOperator::six_node_corrected})
      for (const double aspect : {1.0, 8.0}) {  // uneven cells, then slivers
        CAPTURE(aspect);
        const mesh::SurfaceMesh mesh(mapped(square(Pattern::jittered, 6), [&](const Vec3& x) {
          return Vec3(aspect * x[0], x[1], 0.3 * std::cos(2.0 * x[0]) + 0.2 * x[1] * x[1] - 0.2 * x[0] * x[1]);
        }));
        system::ModelInput input;
        input.element.bending = op;
        input.element.membrane = membrane;
        input.materials = {isotropic(1.0, 0.3, 0.1)};
        system::Model model(PETSC_COMM_WORLD, mesh, input);
        petsc::VecHandle a = model.dofs().create_vector(), f = model.dofs().create_vector();
        model.residual(a, f);
        CHECK(norm(f) < 1e-13);
        CHECK(std::abs(model.energy(a)) < 1e-14);
        model.assemble_tangent(a, {.kind = energy::Tangent::exact});
        const Eigen::VectorXd e = eigenvalues(dense_tangent(model));
        CHECK(std::abs(e[0]) < 1e-13 * e.maxCoeff());
        CHECK(std::abs(e[5]) < 1e-13 * e.maxCoeff());
        CHECK(e[6] > 1e-9 * e.maxCoeff());
      }
}

TEST_CASE("how a flat sheet bends does not depend on the order of its triangles") {
  mesh::MeshData given = square(Pattern::jittered, 6), turned = given;
  std::reverse(turned.triangles.begin(), turned.triangles.end());
  for (mesh::Group& g : turned.groups)
    for (Index& t : g.triangles) t = static_cast<Index>(turned.triangles.size()) - 1 - t;
  const std::vector<energy::Material> materials{isotropic(1.0, 0.3, 1.0)};
  std::vector<std::vector<std::map<Index, Vec3>>> found;
  for (const mesh::MeshData& data : {given, turned}) {
    const mesh::SurfaceMesh mesh(data);
    const mesh::PatchMesh patches(mesh, {});
    const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), {});
    energy::CurvatureBuilder builder(sheet);
    found.emplace_back();
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
      const energy::CurvatureOperator k = builder.build(t);
      std::map<Index, Vec3>& weights = found.back().emplace_back();
      for (std::size_t i = 0; i < k.points.size(); ++i)
        weights[k.points[i]] = k.weights.col(static_cast<Eigen::Index>(i));
    }
  }
  std::reverse(found[1].begin(), found[1].end());
  double worst = 0.0, largest = 0.0;
  for (std::size_t t = 0; t < found[0].size(); ++t)
    for (const auto& [point, weight] : found[0][t]) {
      largest = std::max(largest, weight.norm());
      worst = std::max(worst, (weight - found[1][t].try_emplace(point, Vec3::Zero()).first->second).norm());
    }
  CHECK(worst < 1e-9 * largest);
}

}  // namespace test_patch

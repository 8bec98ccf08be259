// Division over the ranks: one owner each, contiguous rows, reproducible and balanced.
#include <doctest/doctest.h>

#include <numeric>
#include <set>

#include "mesh/partition.hpp"
#include "test_model_kit.hpp"
#include "voile/errors.hpp"

namespace test_partition {

using namespace voile;
using namespace voile::testing;

namespace {

mesh::MeshData two_triangles() {
  mesh::MeshData d;
  d.source = "pair";
  d.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  d.triangles = {{0, 1, 2}, {0, 2, 3}};
  return d;
}

}  // namespace

TEST_CASE("every vertex and triangle has one owner and rows are numbered rank by rank, in mesh order") {
  const int ranks = mpi::size(PETSC_COMM_WORLD);
  for (const Pattern pattern : {Pattern::diagonal, Pattern::gmsh}) {
    const mesh::SurfaceMesh mesh(square(pattern, 12));
    const mesh::Partition p = mesh::make_partition(PETSC_COMM_WORLD, mesh);
    const auto nv = static_cast<std::size_t>(mesh.vertex_count());
    REQUIRE(p.vertex_rank.size() == nv);
    REQUIRE(p.triangle_rank.size() == static_cast<std::size_t>(mesh.triangle_count()));
    REQUIRE(p.row_start.size() == static_cast<std::size_t>(ranks) + 1);
    CHECK(p.row_start.front() == 0);
    CHECK(p.row_start.back() == mesh.vertex_count());
    std::set<Index> rows(p.row_of.begin(), p.row_of.end());
    CHECK(rows.size() == nv);
    CHECK(*rows.begin() == 0);
    CHECK(*rows.rbegin() == mesh.vertex_count() - 1);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      CHECK(p.vertex_of[p.row_of[v]] == v);
      const int r = p.vertex_rank[v];
      REQUIRE(r >= 0);
      REQUIRE(r < ranks);
      CHECK(p.row_of[v] >= p.owned_begin(r));
      CHECK(p.row_of[v] < p.owned_begin(r) + p.owned_count(r));
    }
    for (Index row = 1; row < mesh.vertex_count(); ++row)
      if (p.vertex_rank[p.vertex_of[row]] == p.vertex_rank[p.vertex_of[row - 1]])
        CHECK(p.vertex_of[row] > p.vertex_of[row - 1]);
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
      int votes = 0, best = 0;
      for (Index v : mesh.triangles()[t]) votes += p.vertex_rank[v] == p.triangle_rank[t] ? 1 : 0;
      for (Index v : mesh.triangles()[t]) {
        int same = 0;
        for (Index w : mesh.triangles()[t]) same += p.vertex_rank[w] == p.vertex_rank[v] ? 1 : 0;
        best = std::max(best, same);
      }
      CHECK(votes == best);
    }
  }
}

TEST_CASE("the division is the same on every rank and every time") {
  const mesh::SurfaceMesh mesh(square(Pattern::gmsh, 12));
  const mesh::Partition p = mesh::make_partition(PETSC_COMM_WORLD, mesh);
  const mesh::Partition again = mesh::make_partition(PETSC_COMM_WORLD, mesh);
  CHECK(p.vertex_rank == again.vertex_rank);
  CHECK(p.triangle_rank == again.triangle_rank);
  CHECK(p.row_of == again.row_of);
  std::vector<Index> of_root = p.row_of;
  mpi::broadcast(PETSC_COMM_WORLD, of_root);
  CHECK(of_root == p.row_of);
  CHECK(mesh::divide_vertices(mesh, mpi::size(PETSC_COMM_WORLD)) == p.vertex_rank);
}

TEST_CASE("parts are balanced within a tenth and not scattered") {
  const mesh::SurfaceMesh mesh(grid(40, 40, false, 0.0));
  for (int parts = 1; parts <= 4; ++parts) {
    CAPTURE(parts);
    const std::vector<int> part = mesh::divide_vertices(mesh, parts);
    std::vector<int> size(static_cast<std::size_t>(parts), 0);
    for (int r : part) ++size[static_cast<std::size_t>(r)];
    for (int n : size) CHECK(std::abs(n * parts - mesh.vertex_count()) <= 0.1 * mesh.vertex_count());
    int cut = 0;
    for (const mesh::Triangle& t : mesh.triangles())
      cut += part[t[0]] == part[t[1]] && part[t[1]] == part[t[2]] ? 0 : 1;
    // Straight cuts through the square meet 2 x 40 triangles each; scattered parts would meet most of the 3200.
    CHECK(cut <= 2 * 80 * (parts - 1));
    CHECK((cut > 0) == (parts > 1));
  }
}

TEST_CASE("more ranks than vertices are the user's mistake") {
  const mesh::SurfaceMesh mesh(two_triangles());
  CHECK_THROWS_AS((void)mesh::divide_vertices(mesh, 5), UserError);
  if (mpi::size(PETSC_COMM_WORLD) > mesh.vertex_count())
    CHECK_THROWS_AS((void)mesh::make_partition(PETSC_COMM_WORLD, mesh), UserError);
}

TEST_CASE("a mesh of two triangles can be solved on as many ranks as there are") {
  const mesh::SurfaceMesh mesh(two_triangles());
  if (mpi::size(PETSC_COMM_WORLD) > mesh.vertex_count()) return;
  system::ModelInput input;
  input.materials = {isotropic(1.0, 0.3, 0.1)};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  petsc::VecHandle a = model.dofs().create_vector(), r = model.dofs().create_vector(), f = model.dofs().create_vector(),
                   x = model.dofs().create_vector();
  set_displacement(model, a, noise(0.1, 3));
  model.residual(a, r);
  model.assemble_tangent(a, {.kind = energy::Tangent::positive, .mass = 1.0});
  set_displacement(model, f, noise(1.0, 5));
  solve_linear(model, f, x);
  VOILE_PETSC(MatMult(model.tangent().matrix(), x, r));
  VOILE_PETSC(VecAXPY(r, -1.0, f));
  CHECK(norm(f) > 0.1);
  CHECK(norm(r) < 1e-12 * norm(f));
}

}  // namespace test_partition

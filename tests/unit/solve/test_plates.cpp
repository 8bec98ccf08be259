// Linear plates under uniform load: second order on every mesh, in order and in magnitude.
//
// References, unit square, nu = 0.3, q L^4/D = 1: clamped centre 0.00126532 (Timoshenko & Woinowsky-Krieger, Theory of
// Plates and Shells, table 35: 0.00126), simply supported centre 0.00406235 (Navier series), cantilever middle of the
// free edge 0.12908 (Richardson value of this operator on diagonal meshes, see runs/convergence/README.md).
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>

#include "extent.hpp"
#include "test_model_kit.hpp"

namespace test_plates {

using namespace voile;
using namespace voile::testing;

namespace {

struct Plate {
  std::string name;
  double reference;
  Vec2 point;
  std::vector<system::Support> supports;
};

std::vector<Plate> plates() {
  using Kind = system::Support::Kind;
  std::vector<Plate> p{{"clamped", 0.00126532, {0.5, 0.5}, {}},
                       {"simply supported", 0.00406235, {0.5, 0.5}, {}},
                       {"cantilever", 0.12908, {1.0, 0.5}, {support("left", Kind::clamped)}}};
  for (const char* edge : {"left", "right", "bottom", "top"}) {
    p[0].supports.push_back(support(edge, Kind::clamped));
    p[1].supports.push_back(support(edge, Kind::hinged));
  }
  return p;
}

/// Deflection at the point by the linear problem with D = 1, relative to the reference.
double ratio(const Plate& plate, Pattern pattern, int n) {
  const mesh::SurfaceMesh mesh(square(pattern, n));
  system::ModelInput input;
  energy::Material m = isotropic(1.0, 0.3, 1.0);
  m.bending /= m.bending(0, 0);
  input.materials = {m};
  input.supports = plate.supports;
  system::Load load;
  load.kind = system::Load::Kind::area;
  load.vector = Vec3(0.0, 0.0, 1.0);
  input.loads = {load};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  model.conditions().set_load_factor(1.0);
  petsc::VecHandle zero = model.dofs().create_vector(), r = model.dofs().create_vector(),
                   a = model.dofs().create_vector();
  model.residual(zero, r);
  model.assemble_tangent(zero, {.kind = energy::Tangent::exact});
  solve_linear(model, r, a);
  const std::vector<double> u = model.dofs().gather(a);
  double w = 0.0;
  if (mpi::rank(PETSC_COMM_WORLD) == 0) {
    Index best = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
      if ((mesh.positions()[v].head<2>() - plate.point).norm() <
          (mesh.positions()[best].head<2>() - plate.point).norm())
        best = v;
    w = -u[3 * best + 2];
  }
  return mpi::sum(PETSC_COMM_WORLD, w) / plate.reference;
}

}  // namespace

TEST_CASE("edge_slope plates converge with second order on four kinds of mesh") {
  const bool root = mpi::rank(PETSC_COMM_WORLD) == 0;
  // The finest level is run on one rank only; the rank comparison has its own test.
  const int finest = extent(mpi::size(PETSC_COMM_WORLD) == 1 ? 64 : 32, 16);
  for (const Plate& plate : plates())
    for (const Pattern pattern : {Pattern::diagonal, Pattern::union_jack, Pattern::jittered, Pattern::gmsh}) {
      std::vector<double> error;
      for (int n = 8; n <= finest; n *= 2) error.push_back(ratio(plate, pattern, n) - 1.0);
      std::string text;
      for (double e : error) text += fmt::format(" {:.4f}", 1.0 + e);
      if (root) MESSAGE(plate.name << ", " << name_of(pattern) << ":" << text);
      CAPTURE(plate.name);
      CAPTURE(name_of(pattern));
      const double order = std::log2(std::abs(error[0] / error.back())) / static_cast<double>(error.size() - 1);
      CHECK(order > 1.8);
      if (finest >= 32) CHECK(std::abs(error[2]) < 0.014);
      if (finest == 64) CHECK(std::abs(error[3]) < 0.0035);
    }
}

}  // namespace test_plates

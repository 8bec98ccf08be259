// Dimples: vertices that stand out from their neighbours.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "record/dimples.hpp"
#include "test_meshes.hpp"

namespace test_dimples {

using namespace voile;
using namespace voile::testing;

namespace {

/// w(x, y) on a unit square of n x n cells.
template <class F>
record::Dimple dimple(int n, const F& w, bool mirrored = false) {
  const mesh::SurfaceMesh mesh(grid(n, n, false, 0.0));
  std::vector<double> u(3 * mesh.positions().size(), 0.0);
  for (std::size_t v = 0; v < mesh.positions().size(); ++v) u[3 * v + 2] = w(mesh.positions()[v]);
  return record::deepest_dimple(mesh, std::vector<char>(mesh.positions().size(), mirrored ? 1 : 0), u);
}

}  // namespace

TEST_CASE("waves that the mesh resolves are no dimples, a vertex that stands out is one") {
  const auto wave = [](const Vec3& x) {
    return std::sin(2.0 * std::numbers::pi * x[0]) * std::sin(2.0 * std::numbers::pi * x[1]);
  };
  CHECK(dimple(8, wave).depth < 0.4);
  CHECK(dimple(16, wave).depth < 0.1);
  CHECK(dimple(8, [](const Vec3& x) { return 2.0 + 3.0 * x[0] - x[1]; }).depth < 1e-12);
  const auto pressed = [](const Vec3& x) { return (x - Vec3(0.5, 0.5, 0.0)).norm() < 1e-9 ? 4.0 : 1.0; };
  CHECK(dimple(8, pressed).depth == doctest::Approx(0.75));
  // On the boundary only where the surface goes on behind a mirror.
  const auto corner = [](const Vec3& x) { return x.norm() < 1e-9 ? 4.0 : 1.0; };
  CHECK(dimple(8, corner).depth < 0.3);
  CHECK(dimple(8, corner, true).depth == doctest::Approx(0.75));
}

}  // namespace test_dimples

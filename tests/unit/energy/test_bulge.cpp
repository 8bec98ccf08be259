// What a bent triangle encloses beyond its plane.
#include "energy/bulge.hpp"

#include <doctest/doctest.h>

#include "../test_meshes.hpp"
#include "../test_model_kit.hpp"
#include "../test_relative.hpp"

namespace test_bulge {

using namespace voile;
using namespace voile::testing;

namespace {

/// Twice the second derivative of z along a side.
double bend_along(const Vec3& side) {
  return 3.0 * side[0] * side[0] - 4.0 * side[0] * side[1] - 2.0 * side[1] * side[1];
}
double height(const Vec3& p) {
  return 0.5 * bend_along(p);
}

}  // namespace

TEST_CASE("a flat sheet bent to any quadric encloses what is between it and its triangles") {
  for (const Pattern pattern : {Pattern::diagonal, Pattern::jittered, Pattern::gmsh}) {
    CAPTURE(name_of(pattern));
    const mesh::SurfaceMesh mesh(square(pattern, 6));
    const mesh::PatchMesh patches(mesh, {});
    const std::vector<energy::Material> materials{isotropic(1.0, 0.3, 0.1)};
    const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), {});
    energy::CurvatureBuilder builder(sheet);
    std::vector<Vec3> x = mesh.positions();
    for (Vec3& p : x) p[2] = height(p);
    int inner = 0;
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
      const mesh::Triangle& corners = mesh.triangles()[t];
      if (std::any_of(corners.begin(), corners.end(), [&](Index v) {
            return (mesh.positions()[v].head<2>() - Vec2(0.5, 0.5)).cwiseAbs().maxCoeff() > 0.3;
          }))
        continue;  // free edges straighten the curvature
      const energy::Bulge bulge = energy::make_bulge(sheet, t, corners, builder.build(t));
      // Of a quadratic over a triangle, less its linear interpolant: -area/24 sum of its second derivatives along the sides.
      double exact = 0.0;
      for (std::size_t i = 0; i < 3; ++i)
        exact -=
            mesh.area(t) / 24.0 * bend_along(mesh.positions()[corners[(i + 1) % 3]] - mesh.positions()[corners[i]]);
      CHECK(bulge.volume({x.data(), bulge.points.data()}) == relative(exact).epsilon(1e-10));
      ++inner;
    }
    CHECK(inner > 5);
  }
}

}  // namespace test_bulge

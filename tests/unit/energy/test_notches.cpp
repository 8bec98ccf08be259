// Notches that are small for the thickness of a sheet.
#include "energy/notches.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "../test_model_kit.hpp"

namespace test_notches {

using namespace voile;
using namespace voile::testing;

namespace {

constexpr int around = 24, rings = 6;
constexpr double side = 4.0;

/// A square with a round hole of radius 1 in its middle, or cut through the middle so that the hole lies at its corners.
struct Plate {
  mesh::MeshData data;
  std::vector<Index> root;  ///< as in a periodic sheet

  explicit Plate(bool cut) {
    std::map<std::array<long, 2>, Index> vertex_at, root_at;
    const auto add = [&](Vec3 x, const Vec3& middle) {
      if (cut)
        for (int k = 0; k < 2; ++k) x[k] += middle[k] < 0.0 ? side : 0.0;
      const auto key = [](const Vec3& p) { return std::array{std::lround(1e6 * p[0]), std::lround(1e6 * p[1])}; };
      const auto [at, is_new] = vertex_at.emplace(key(x), static_cast<Index>(data.positions.size()));
      if (!is_new) return at->second;
      data.positions.push_back(x);
      Vec3 repeated = x;
      for (int k = 0; k < 2; ++k) repeated[k] -= side * std::floor((x[k] + 0.5 * side) / side + 1e-9);
      root.push_back(root_at.emplace(key(repeated), at->second).first->second);
      return at->second;
    };
    for (int i = 0; i < around; ++i)
      for (int j = 0; j < rings; ++j) {
        const std::array<Vec3, 4> corners{place(i, j), place(i, j + 1), place(i + 1, j + 1), place(i + 1, j)};
        const Vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
        for (const std::array<std::size_t, 3>& t : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}})
          data.triangles.push_back(
              {add(corners[t[0]], middle), add(corners[t[1]], middle), add(corners[t[2]], middle)});
      }
    for (std::size_t v = 0; v < data.positions.size(); ++v) data.vertex_tags.push_back(static_cast<Index>(v) + 1);
    for (std::size_t t = 0; t < data.triangles.size(); ++t) data.triangle_tags.push_back(static_cast<Index>(t) + 1);
  }

  /// On a spoke from the hole to the border.
  static Vec3 place(int i, int j) {
    const double angle = 2.0 * std::numbers::pi * i / around, s = static_cast<double>(j) / rings;
    const Vec3 on_hole(std::cos(angle), std::sin(angle), 0.0);
    return (1.0 - s) * on_hole + s * 0.5 * side * on_hole / on_hole.cwiseAbs().maxCoeff();
  }
};

std::vector<char> near(const Plate& plate, double thickness, bool periodic) {
  const mesh::SurfaceMesh mesh(mesh::MeshData(plate.data));
  const mesh::PatchMesh patches(mesh, {});
  const std::vector<energy::Material> materials{isotropic(1.0, 0.3, thickness)};
  const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), {});
  return energy::near_notches(sheet, periodic ? plate.root : std::vector<Index>{});
}

}  // namespace

TEST_CASE("a hole counts as a notch where its radius is below twenty thicknesses, corners and convex edges do not") {
  const Plate plate(false);
  CHECK(near(plate, 0.04, false).empty());
  const std::vector<char> found = near(plate, 0.1, false);
  REQUIRE(found.size() == plate.data.triangles.size());
  for (std::size_t t = 0; t < found.size(); ++t) {
    double nearest = side, farthest = 0.0;  // from the middle
    for (const Index v : plate.data.triangles[t]) {
      nearest = std::min(nearest, plate.data.positions[v].norm());
      farthest = std::max(farthest, plate.data.positions[v].norm());
    }
    CAPTURE(nearest);
    if (nearest < 1.9) CHECK(found[t] == 1);
    if (nearest > 2.1) CHECK(found[t] == 0);
  }
  CHECK(std::count(found.begin(), found.end(), 0) > 10);
  // Where a periodic cell is cut makes no difference.
  CHECK(near(plate, 0.1, true) == found);
  CHECK(near(Plate(true), 0.1, true) == found);
}

}  // namespace test_notches

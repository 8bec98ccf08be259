// Means over groups do not depend on the sizes of cells.
#include <doctest/doctest.h>

#include <cmath>

#include "mesh/group_weights.hpp"

namespace test_group_weights {

using namespace voile;

TEST_CASE("the mean of a group is over its length or area, of points over their number") {
  // A strip 1 x 0.2 whose columns of vertices come closer towards x = 0.
  mesh::MeshData m;
  m.source = "test";
  const int columns = 9;
  for (int i = 0; i < columns; ++i)
    for (const double y : {0.0, 0.2}) m.positions.emplace_back(std::pow(i / 8.0, 3), y, 0.0);
  mesh::Group sheet{"sheet", 2, {}, {}, {}}, low{"low", 1, {}, {}, {}}, ends{"ends", 0, {0, 16, 17}, {}, {}};
  for (Index i = 0; i + 1 < columns; ++i) {
    const Index a = 2 * i;
    m.triangles.push_back({a, a + 2, a + 3});
    m.triangles.push_back({a, a + 3, a + 1});
    low.segments.push_back({a, a + 2});
  }
  for (Index t = 0; t < static_cast<Index>(m.triangles.size()); ++t) sheet.triangles.push_back(t);
  for (Index v = 0; v < 2 * columns; ++v) sheet.vertices.push_back(v);
  for (Index v = 0; v < 2 * columns; v += 2) low.vertices.push_back(v);
  m.groups = {sheet, low, ends};
  const mesh::SurfaceMesh surface(std::move(m));
  const auto centre = [&](const char* name) {
    const mesh::Group& group = surface.group(name);
    const std::vector<double> weights = mesh::group_weights(surface, group);
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * surface.positions()[group.vertices[i]];
    return sum;
  };
  CHECK((centre("sheet") - Vec3(0.5, 0.1, 0.0)).norm() < 1e-14);
  CHECK((centre("low") - Vec3(0.5, 0.0, 0.0)).norm() < 1e-14);
  CHECK((centre("ends") - Vec3(2.0 / 3.0, 0.2 / 3.0, 0.0)).norm() < 1e-14);
}

}  // namespace test_group_weights

#include "hanging_vertices.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "closest_triangle.hpp"
#include "mesh/coincident.hpp"
#include "mesh/sorted_points.hpp"

namespace voile::geometry {

HangingVertices find_hanging(const mesh::MeshData& data, double tolerance, Beside beside,
                             const std::vector<mesh::Segment>& rims) {
  HangingVertices found;
  if (!(tolerance > 0.0)) return found;
  const std::vector<Vec3>& x = data.positions;
  std::vector<char> used(x.size(), 0), at_rim(x.size(), 0), hangs(x.size(), 0);
  for (const mesh::Triangle& t : data.triangles)
    for (const Index v : t) used[v] = 1;
  std::vector<mesh::Segment> edges = mesh::rim_edges(data);
  edges.insert(edges.end(), rims.begin(), rims.end());
  for (const mesh::Segment& e : edges) at_rim[e[0]] = at_rim[e[1]] = 1;
  std::vector<Index> rim, all;
  for (Index v = 0; v < static_cast<Index>(x.size()); ++v) {
    if (at_rim[v]) rim.push_back(v);
    if (used[v]) all.push_back(v);
  }
  const auto at_corner = [&](Index v, const auto& corners) {
    return std::any_of(corners.begin(), corners.end(), [&](const Vec3& c) { return (x[v] - c).norm() <= tolerance; });
  };
  std::vector<std::vector<mesh::Segment>> own(x.size());  // sides of the triangles of each vertex
  if (beside == Beside::skipped)
    for (const mesh::Triangle& t : data.triangles)
      for (const Index v : t)
        for (std::size_t s = 0; s < 3; ++s) own[v].push_back(mesh::ascending(t[s], t[(s + 1) % 3]));
  const auto is_own = [&](Index v, Index a, Index b) {
    return std::find(own[v].begin(), own[v].end(), mesh::ascending(a, b)) != own[v].end();
  };
  const mesh::SortedPoints at_rims(x, rim), anywhere(x, all);
  for (const mesh::Triangle& t : data.triangles) {
    const std::array corners{x[t[0]], x[t[1]], x[t[2]]};
    const Vec3 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]).array() - tolerance;
    const Vec3 high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]).array() + tolerance;
    at_rims.each_near(corners, tolerance, [&](Index v) {
      if ((x[v].array() < low.array()).any() || (x[v].array() > high.array()).any() || at_corner(v, corners)) return;
      if (is_own(v, t[0], t[1]) || is_own(v, t[1], t[2]) || is_own(v, t[2], t[0])) return;
      const Vec3 w = nearest_weights(x[v], corners);
      if ((w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2] - x[v]).norm() <= tolerance) hangs[v] = 1;
    });
  }
  for (const mesh::Segment& e : edges) {
    const std::array corners{x[e[0]], x[e[1]]};
    const Vec3 along = corners[1] - corners[0];
    anywhere.each_near(corners, tolerance, [&](Index v) {
      const double s = (x[v] - corners[0]).dot(along) / along.squaredNorm();
      if (!(s > 0.0 && s < 1.0) || at_corner(v, corners) || is_own(v, e[0], e[1])) return;
      if ((corners[0] + s * along - x[v]).norm() <= tolerance) hangs[v] = 1;
    });
  }
  for (const Index v : all)
    if (hangs[v] && found.count++ == 0) found.place = x[v];
  return found;
}

}  // namespace voile::geometry

// Checks of remeshed meshes that many tests share.
#pragma once

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "adapt/remesh.hpp"
#include "adapt/sizing.hpp"
#include "test_meshes.hpp"

namespace voile::testing {

using adapt::Limits;
using adapt::Options;
using adapt::Remeshed;
using adapt::RestSurface;

inline double group_area(const mesh::SurfaceMesh& m, const std::string& name) {
  double sum = 0.0;
  for (Index t : m.group(name).triangles) sum += m.area(t);
  return sum;
}

inline double group_length(const mesh::SurfaceMesh& m, const std::string& name) {
  double sum = 0.0;
  for (const mesh::Segment& e : m.group(name).segments) sum += m.rest_length(e);
  return sum;
}

inline Index boundary_sides(const mesh::SurfaceMesh& m) {
  Index n = 0;
  for (Index t = 0; t < m.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) n += m.neighbour(t, s) == no_index;
  return n;
}

/// Vertices - edges + triangles.
inline Index euler(const mesh::SurfaceMesh& m) {
  const Index edges = (3 * m.triangle_count() + boundary_sides(m)) / 2;
  return m.vertex_count() - edges + m.triangle_count();
}

/// Sizes from a function of the place at rest; without charts.
inline std::vector<double> sizes(const mesh::SurfaceMesh& m, const std::function<double(const Vec3&)>& f) {
  std::vector<double> h;
  for (const Vec3& x : m.positions()) h.push_back(f(x));
  return h;
}

/// What must hold of every result: lists that fit, sources that are where the vertex is, orientation as it was.
inline void check_result(const mesh::SurfaceMesh& before, const Remeshed& r, const mesh::SurfaceMesh& after) {
  CHECK(after.reoriented_count() == 0);
  CHECK(after.component_count() == before.component_count());
  CHECK(euler(after) == euler(before));
  REQUIRE(r.kept.size() == static_cast<std::size_t>(after.vertex_count()));
  REQUIRE(r.source.size() == r.kept.size());
  REQUIRE(r.places.size() == r.kept.size());
  double worst = 0.0;
  bool weights = true, same = true;
  for (std::size_t v = 0; v < r.kept.size(); ++v) {
    const auto& at = r.source[v];
    double sum = 0.0;
    Vec3 x = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      weights = weights && at.weights[i] >= 0.0;
      sum += at.weights[i];
      x += at.weights[i] * before.start_corner(at.triangle, static_cast<int>(i));
    }
    weights = weights && std::abs(sum - 1.0) < 1e-12;
    worst = std::max(worst, (x - after.positions()[v]).norm());
    if (r.kept[v] != no_index) same = same && after.positions()[v] == before.positions()[r.kept[v]];
  }
  CHECK(weights);
  CHECK(same);
  INFO("distance of a vertex from its source ", worst, ", extent ", before.extent());
  CHECK(worst < 0.02 * before.extent());
}

inline Remeshed remeshed(const mesh::SurfaceMesh& m, const RestSurface& rest, const std::vector<double>& h,
                         const Limits& limits = {}, const Options& options = {}) {
  return adapt::remesh(m, rest, m.positions(), h, limits, options);
}

}  // namespace voile::testing

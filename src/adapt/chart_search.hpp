// Points in the rest charts of a mesh: the nearest triangle of the same chart.
#pragma once

#include <array>
#include <vector>

#include "half_edges.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::adapt {

/// Nearest point of a triangle to p: barycentric weights, none negative.
[[nodiscard]] std::array<double, 3> nearest_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Copies the rest corners of a mesh. Charts end at seams, also at those of texture coordinates.
class ChartSearch {
 public:
  explicit ChartSearch(const mesh::SurfaceMesh& mesh);

  struct Hit {
    Index triangle = no_index;
    std::array<double, 3> weights{};
    double squared_distance = 0.0;
  };
  /// Nearest point to p in the chart of triangle `from`, by descent from there.
  [[nodiscard]] Hit nearest(const Vec3& p, Index from) const;
  /// Triangle with the nearest centroid among those whose normal is within 90 degrees of `normal`.
  [[nodiscard]] Index locate(const Vec3& p, const Vec3& normal) const;

  [[nodiscard]] const std::array<Vec3, 3>& rest(Index t) const { return rest_[t]; }
  [[nodiscard]] Index chart(Index t) const { return chart_[t]; }
  /// Triangles around the vertices of t, itself included, ascending for each vertex.
  template <typename F>
  void around(Index t, const F& visit) const {
    for (Index v : triangles_[t])
      for (Index k = start_[v]; k < start_[v + 1]; ++k) visit(of_vertex_[k]);
  }
  /// The first triangle of a vertex.
  [[nodiscard]] Index triangle_of(Index v) const { return of_vertex_[start_[v]]; }
  [[nodiscard]] const mesh::Triangle& vertices(Index t) const { return triangles_[t]; }

 private:
  void make_charts(const mesh::SurfaceMesh& mesh);
  void make_grid();
  [[nodiscard]] std::array<std::int64_t, 3> cell_of(const Vec3& p) const;
  [[nodiscard]] Hit hit(const Vec3& p, Index t) const;

  std::vector<mesh::Triangle> triangles_;
  std::vector<std::array<Vec3, 3>> rest_;
  std::vector<Index> chart_, start_, of_vertex_;
  Vec3 low_ = Vec3::Zero();
  double cell_ = 1.0;
  std::array<std::int64_t, 3> cells_{1, 1, 1};
  std::vector<std::pair<std::int64_t, Index>> grid_;  ///< cell of the centroid and triangle, ascending
};

}  // namespace voile::adapt

// Vertices at which parts that are tied divide each other's triangles.
#pragma once

#include <map>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::geometry {

class TiePoints {
 public:
  TiePoints(mesh::MeshData& data, double tolerance) : data_(&data), tolerance_(tolerance) {}

  [[nodiscard]] const Vec3& x(Index v) const { return data_->positions[v]; }
  [[nodiscard]] double tolerance() const { return tolerance_; }
  /// Whether a vertex is an end of an edge (ascending) or divides it.
  [[nodiscard]] bool is_on(Index v, const mesh::Segment& edge) const;
  void put_on(Index v, const mesh::Segment& edge);
  /// In a triangle, or on its sides within the tolerance. Returns false for its corners.
  bool put_in(Index v, Index triangle);
  /// A vertex that divides one of two edges there already, of another rim along the same line, or a new one.
  [[nodiscard]] Index vertex_at(const Vec3& place, const mesh::Segment& edge, const mesh::Segment& other);
  /// Sorts what divides edges from their first to their second end.
  void sort();
  /// Vertices from a to b, both included; after sort() in order.
  [[nodiscard]] std::vector<Index> chain(Index a, Index b) const;
  [[nodiscard]] const std::vector<Index>& inside(Index triangle) const;
  /// Corners, and what is on the sides of a triangle and in it.
  [[nodiscard]] std::vector<Index> of_triangle(Index triangle) const;
  /// All vertices that divide something. In order.
  [[nodiscard]] std::vector<Index> all() const;

 private:
  mesh::MeshData* data_;
  double tolerance_;
  std::map<mesh::Segment, std::vector<Index>> on_edge_;
  std::map<Index, std::vector<Index>> inside_;
};

}  // namespace voile::geometry

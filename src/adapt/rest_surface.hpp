// The rest shape of the first mesh, kept for the whole run, so that meshes made later approach it and not each other.
//
// Surface   In flat charts the triangles themselves. Where the rest shape is curved, a quadratic of height over the
//           tangent plane at each vertex, through the vertex, fitted to the vertices around it on the same smooth piece;
//           in a triangle the three are blended by barycentric weights. Smooth pieces end at creases and seams.
// Curves    Boundaries, group lines, borders of groups, seams and creases, between corners: cubics through the vertices,
//           with the tangents of circles through three of them. Straight stretches stay straight, exactly. A seam is a
//           curve in each of its two charts.
// A point is found by the curve or triangle it lies on or next to, in its own chart.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::adapt {

class RestSurface {
 public:
  /// Copies what it needs. Not collective.
  explicit RestSurface(const mesh::SurfaceMesh& first);
  ~RestSurface();
  RestSurface(RestSurface&&) noexcept;
  RestSurface& operator=(RestSurface&&) noexcept;

  /// Whether any chart is curved; if not, on_surface() returns its argument.
  [[nodiscard]] bool curved() const;
  /// Triangle of the first mesh nearest to a rest position whose normal is within 90 degrees of `normal`.
  [[nodiscard]] Index locate(const Vec3& rest, const Vec3& normal) const;
  /// The point of the rest surface at a position near to it [m]. `triangle`: where to begin the search, and where it
  /// ended.
  [[nodiscard]] Vec3 on_surface(const Vec3& rest, Index& triangle) const;
  /// The middle by length of the curve from a to b, both on it [m]; nothing if no curve that bends runs
  /// through both.
  [[nodiscard]] std::optional<Vec3> curve_middle(const Vec3& a, const Vec3& b) const;
  /// Largest distance [m] of the curve between a and b from the straight edge; 0 if no curve runs through both.
  [[nodiscard]] double curve_deviation(const Vec3& a, const Vec3& b) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voile::adapt

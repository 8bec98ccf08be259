// A mesh that a remeshing has made, and points as lists of numbers.
#pragma once

#include <memory>
#include <vector>

#include "adapt/remesh.hpp"
#include "adapt/sizing.hpp"
#include "remesher.hpp"

namespace voile::remesh {

/// A new mesh on every rank, and on rank 0 where it comes from.
struct Remesher::NewMesh {
  std::shared_ptr<const mesh::SurfaceMesh> mesh;
  adapt::Remeshed from;      ///< rank 0
  adapt::SizeMatch match;    ///< rank 0: how well it meets the sizes
  std::vector<Vec3> places;  ///< rank 0: of the old vertices
};

/// Three numbers per point.
[[nodiscard]] inline std::vector<Vec3> as_points(const std::vector<double>& values) {
  std::vector<Vec3> points;
  points.reserve(values.size() / 3);
  for (std::size_t i = 0; i + 2 < values.size(); i += 3) points.emplace_back(values[i], values[i + 1], values[i + 2]);
  return points;
}

[[nodiscard]] inline std::vector<double> as_values(const std::vector<Vec3>& points) {
  std::vector<double> values;
  values.reserve(3 * points.size());
  for (const Vec3& x : points) values.insert(values.end(), x.begin(), x.end());
  return values;
}

}  // namespace voile::remesh

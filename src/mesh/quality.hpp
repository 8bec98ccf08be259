// Shape of the triangles of a surface and of their patches: what decides how well the element does.
//
// Symbols   l    longest side of a triangle [m]      h   its height on that side [m]
//           aspect       l / h, 1.15 for an equilateral triangle
//           unevenness   |x_s + x_n - x_a - x_b| / l, the largest over the sides s = (a, b) with a neighbour whose apex
//                        x_n is unfolded into the plane: 0 on any grid of equal cells cut the same way, however long
// Chord strains of the nonlinear membrane lock where long cells are uneven: a neighbour's apex that lies off by a fraction
// of l counts as bending about the short side.
#pragma once

#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

struct TriangleShape {
  double smallest_angle = 0.0;  ///< [rad]
  double aspect = 0.0;
  double unevenness = 0.0;
};

/// Not collective.
[[nodiscard]] TriangleShape shape_of(const SurfaceMesh& mesh, Index t);
[[nodiscard]] Vec3 centroid(const SurfaceMesh& mesh, Index t);

}  // namespace voile::mesh

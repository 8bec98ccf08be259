// A triangle divided along given lines, by CGAL's constrained Delaunay triangulation.
#pragma once

#include <array>
#include <vector>

#include "base/types.hpp"

namespace voile::geometry {

using Corners = std::array<Index, 3>;

/// Triangles, counter-clockwise, that fill the polygon `outline` (numbers of points, counter-clockwise), have all points
/// [any unit] in it as corners and all `lines` (pairs of points) as sides. Empty if lines cross each other. Not collective.
[[nodiscard]] std::vector<Corners> divide_polygon(const std::vector<Vec2>& points, const std::vector<Index>& outline,
                                                  const std::vector<std::array<Index, 2>>& lines);

}  // namespace voile::geometry

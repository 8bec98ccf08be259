// Polygons of mesh files as triangles.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "base/types.hpp"

namespace voile::formats {

/// Local numbers of the corners of the triangles that fill the polygon of `corners`, wound as it is; none of two corners. A
/// quadrangle is divided along its shorter diagonal that lies inside; a larger polygon is a fan from its first corner if
/// that fills it, else corners are cut off. A polygon that crosses itself is divided somehow. Not collective.
[[nodiscard]] std::vector<std::array<std::size_t, 3>> split_polygon(const std::vector<Vec3>& corners);

}  // namespace voile::formats

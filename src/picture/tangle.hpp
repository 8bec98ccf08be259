// Triangles that intersect at a start, as a picture: everything, and from near what intersects.
#pragma once

#include <cstdint>
#include <vector>

#include "image.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::picture {

struct Tangle {
  std::vector<Vec3> positions;            ///< [m]
  std::vector<mesh::Triangle> triangles;  ///< of the sheet and of obstacles
  std::vector<Index> piece;               ///< per triangle: piece of the sheet, or no_index: obstacle
  std::vector<std::uint8_t> hit;          ///< per triangle: it intersects
};

/// Pieces in colours, obstacles grey, what intersects red: the whole from before and from behind, without obstacles but for what intersects, since
/// what is in a body would be hidden, and one place from near. At least one triangle is hit and one is of the sheet.
[[nodiscard]] Image picture_of(const Tangle& tangle, int width, int height);

}  // namespace voile::picture

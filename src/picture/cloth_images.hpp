// Cloth as textures for other programs; private to src/picture.
//
// Columns run across the warp, rows from top to bottom against it; both repeat.
#pragma once

#include <array>
#include <vector>

#include "cloth.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::picture {

/// One repeat of the weave's normals: x across, y along the warp, z out of the sheet, each from -1 to 1 as 0 to 255.
[[nodiscard]] Image normal_image(Weave weave);
/// One repeat of the light that reaches its threads, 255 for all of it.
[[nodiscard]] Image shade_image(Weave weave);
/// One repeat of a print, two stripes or checks wide and high.
[[nodiscard]] Image print_image(Print print, const Rgb& ground);

/// A sheet whose vertices have one flat place each: those on seams are there several times.
struct SplitSheet {
  std::vector<mesh::Triangle> triangles;
  std::vector<Index> origin;  ///< vertex of the sheet that each was
  std::vector<Vec2f> flat;    ///< of each [m]
};
[[nodiscard]] SplitSheet split_at_seams(const std::vector<mesh::Triangle>& triangles,
                                        const std::vector<std::array<Vec2f, 3>>& flat);

/// Unit vectors across the warp at the vertices of a split sheet, square to their normals; x of triangles' vertices.
[[nodiscard]] std::vector<Vec3f> tangents_of(const SplitSheet& split, const std::vector<Vec3f>& x,
                                             const std::vector<Vec3f>& normals);

}  // namespace voile::picture

// Flat coordinates of a sheet in the directions of its threads, for weaves and prints.
//
// Symbols   a, l   across the warp and along it, in the unit of the mesh
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"
#include "weave.hpp"

namespace voile::picture {

/// What pictures need of a [[material]]; empty groups: all triangles that no other has.
struct SheetMaterial {
  std::vector<std::string> groups{};
  std::optional<Vec3> direction{};          ///< of material axis 1 in space or charts
  std::optional<Vec2> texture_direction{};  ///< the same in texture coordinates
  double warp_angle = 0.0;                  ///< from that axis to the warp, about the normal [rad]
  double thickness = 0.0;                   ///< in the unit of the mesh; 0: not known
};

/// (a, l) of the three corners of each triangle: its texture coordinates, whose unit makes the sheet as large as it is at
/// rest; its chart without them; its place at the start where it is plane and has neither, or texture that is not of its shape. A
/// material without a direction has its warp along v of the texture, or along x.
/// Throws UserError if a sheet is curved and has neither texture coordinates nor charts.
[[nodiscard]] std::vector<std::array<Vec2f, 3>> flat_coordinates(const mesh::MeshData& mesh,
                                                                 const std::vector<SheetMaterial>& materials);

/// By what the texture coordinates of a curved sheet make lengths uneven, as a fraction: 0 if they are not used.
[[nodiscard]] double uneven_texture(const mesh::MeshData& mesh);

/// Material of each triangle, as a place in the list.
[[nodiscard]] std::vector<std::size_t> materials_of(const mesh::MeshData& mesh,
                                                    const std::vector<SheetMaterial>& materials);

}  // namespace voile::picture

// What is to be seen: surfaces of triangles, and how they look.
#pragma once

#include <optional>
#include <vector>

#include "colour_map.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::picture {

struct Surface {
  std::vector<Vec3f> positions;  ///< [m]
  std::vector<mesh::Triangle> triangles;
  std::vector<Vec3f> normals;         ///< three per triangle, unit length: smooth except at creases
  Rgb front{0, 0, 0}, back{0, 0, 0};  ///< colours of the side that normals point to, and of the other
  float sheen = 0.0F;                 ///< 0 to 1, of cloth at grazing sight
  std::vector<float> values;          ///< per vertex, or per triangle, shown by the scene's scale; empty: plain
  std::vector<Rgb> triangle_colours;  ///< wins over values; empty: none
  std::vector<std::uint8_t>
      marked_sides{};  ///< bit s of a triangle: its side s (opposite to vertex s) is drawn; empty: none
  std::vector<std::uint8_t> red_sides{};  ///< the same in red, over the others
  bool mesh_lines = false;
};

struct Scene {
  std::vector<Surface> surfaces;
  ColourScale scale;
  Vec3 up = Vec3::UnitZ();
  std::optional<double> ground;  ///< its height along `up` [m]; none: nothing to cast a shadow on
  Rgb background_top{1, 1, 1}, background_bottom{0.84F, 0.87F, 0.9F};
};

/// Normals at the corners of triangles: means over the triangles round a vertex by their angles there, over those only whose
/// own normal is less than `crease` radians from the triangle's.
[[nodiscard]] std::vector<Vec3f> corner_normals(const std::vector<Vec3f>& positions,
                                                const std::vector<mesh::Triangle>& triangles, double crease);

}  // namespace voile::picture

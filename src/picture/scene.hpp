// What is to be seen: surfaces of triangles, and how they look.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "cloth.hpp"
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
  bool values_on_triangles = false;
  std::vector<Rgb> triangle_colours;  ///< wins over values; empty: none
  std::vector<std::uint8_t>
      marked_sides{};  ///< bit s of a triangle: its side s (opposite to vertex s) is drawn; empty: none
  std::vector<std::uint8_t> red_sides{};  ///< the same in red, over the others
  bool mesh_lines = false;
  std::shared_ptr<const Cloth> cloth{};      ///< null: smooth, without threads or a print
  std::vector<std::array<Vec2f, 3>> flat{};  ///< of cloth: flat coordinates of each triangle's corners [m]
};

/// How the room is lit: a lamp over the viewer's left shoulder, another from behind on the right, the sky and the floor. The
/// sums are near 1, so that a colour that faces the lamp appears as it is.
struct Lighting {
  Rgb lamp{0.76F, 0.74F, 0.70F}, rim{0, 0, 0}, sky{0.30F, 0.315F, 0.34F}, floor{0.25F, 0.245F, 0.24F};
  float lamp_radius = 0.09F;  ///< of the lamps' discs at unit distance
  /// A studio: wide lamps, bright walls.
  static Lighting studio() {
    return {{0.60F, 0.585F, 0.56F}, {0.28F, 0.29F, 0.31F}, {0.40F, 0.41F, 0.43F}, {0.31F, 0.30F, 0.29F}, 0.4F};
  }
};

struct Scene {
  std::vector<Surface> surfaces;
  ColourScale scale;
  Vec3 up = Vec3::UnitZ();
  std::optional<double> ground;  ///< its height along `up` [m]; none: nothing to cast a shadow on
  Lighting lighting;
  Rgb background_top{1, 1, 1}, background_bottom{0.84F, 0.87F, 0.9F};
};

/// Normals at the corners of triangles: means over the triangles round a vertex by their angles there, over those only whose
/// own normal is less than `crease` radians from the triangle's.
[[nodiscard]] std::vector<Vec3f> corner_normals(const std::vector<Vec3f>& positions,
                                                const std::vector<mesh::Triangle>& triangles, double crease);

/// Gives a sheet its thickness [m]: front and back sides that far apart, and a strip where it ends. Not for sheets with values
/// or colours of triangles.
void thicken(Surface& s, double thickness);

}  // namespace voile::picture

// Triangles in plane polygons, by Gmsh, in the program voile-gmsh.
#pragma once

#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::formats {

/// A polygon that may have holes: closed loops without crossings, either way round; their corners become vertices, their sides
/// edges as they are.
struct Polygon {
  std::string name;                      ///< for messages
  std::vector<std::vector<Vec2>> loops;  ///< the outline and the holes in it
  std::size_t outline = 0;               ///< which of them that is
  double size = 0.0;                     ///< edge length wanted inside, > 0
  std::vector<Vec2> inside{};            ///< points that become vertices, inside of the outline and of no hole
};

struct Triangulation {
  std::vector<Vec2> points;               ///< first those of the loops, then those inside, in their order
  std::vector<mesh::Triangle> triangles;  ///< counter-clockwise
};

/// Not collective: call on one rank. `file`: for messages. Throws UserError if a polygon cannot be meshed.
[[nodiscard]] std::vector<Triangulation> mesh_polygons(const std::string& file, const std::vector<Polygon>& polygons);

}  // namespace voile::formats

// The surface that encloses a gas, oriented outwards, with the rims of its holes.
#pragma once

#include <array>
#include <vector>

#include "conditions.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::system {

struct GasSurface {
  struct Side {  ///< an edge of a rim, as the triangle that closes the hole goes through it
    Index triangle;
    std::array<Index, 2> vertices;
  };
  struct Rim {
    std::vector<Index> vertices;
    std::vector<Side> sides;
  };
  struct Face {
    Index triangle;
    std::array<Index, 3> vertices;
  };
  std::vector<Face> faces;
  std::vector<Rim> rims;  ///< empty where caps have a given apex: they contribute nothing to what is counted from there
  Vec3 origin = Vec3::Zero();  ///< from which the volume is counted: that apex, or the middle of the surface [m]
  double volume = 0.0;         ///< at the start, with the load's added volume [m^3]
};

/// Of a load of kind gas. Throws UserError: the group is of several parts, has edges with more than two of its triangles, or
/// cannot be oriented, or encloses nothing. Not collective.
[[nodiscard]] GasSurface gas_surface(const mesh::SurfaceMesh& mesh, const Load& load);

}  // namespace voile::system

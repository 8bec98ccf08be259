// A sheet as an OBJ file holds it, with lines "stitch a b c t".
//
// Symbols   x_a   place of vertex a [m]      t   fraction of the way from b to c, 0 <= t <= 1
// A stitch holds vertex a at (1 - t) x_b + t x_c. Vertices of stitches count from 0, as in: Li, Kaufman, Jiang, Codimensional
// incremental potential contact, ACM Trans. Graph. 40 (2021), whose program reads such lines.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::formats {

struct PointStitch {
  Index vertex = 0;        ///< a
  Index from = 0, to = 0;  ///< b, c
  double fraction = 0.0;   ///< t
  std::size_t line = 0;    ///< of the file
};

struct ObjSheet {
  mesh::MeshData mesh;  ///< all vertices, in the units of the file; texture is empty if no face has any
  std::vector<PointStitch> stitches;
};

/// Not collective: call on one rank. Throws UserError that names file and line for what cannot be read.
[[nodiscard]] ObjSheet read_obj_sheet(const std::string& file);

}  // namespace voile::formats

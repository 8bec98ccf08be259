// What vertices of a group count in a mean over it, e.g. of displacements: so that the mean does not depend on the sizes of cells.
//
//   w_v = sum of A_t / 3 over its triangles, or of l_e / 2 over its line elements, over the sum of all;  1 / n of points
#pragma once

#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

/// One per vertex of the group, together 1: by rest area of a surface, by length at the start of a curve. Not collective.
[[nodiscard]] std::vector<double> group_weights(const SurfaceMesh& mesh, const Group& group);

}  // namespace voile::mesh

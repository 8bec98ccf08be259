// Where a surface group ends within the mesh.
#pragma once

#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

/// Edges, each ascending, in order, between a triangle of a surface group and one that is not of it.
[[nodiscard]] std::vector<Segment> inner_border(const SurfaceMesh& mesh, const Group& group);

}  // namespace voile::mesh

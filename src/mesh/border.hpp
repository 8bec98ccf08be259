// Where a surface group ends within the mesh.
#pragma once

#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

/// Edges, each ascending, in order, between a triangle of a surface group and one that is not of it.
[[nodiscard]] std::vector<Segment> inner_border(const SurfaceMesh& mesh, const Group& group);

/// Whether a joint only parts a sheet round a clamped surface: two triangles of one sheet, without a hinge.
[[nodiscard]] bool is_clamped_border(const SurfaceMesh& mesh, const Joint& joint);

}  // namespace voile::mesh

// The plane that a symmetry support mirrors the sheet in.
#pragma once

#include "conditions.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::system {

/// Unit normal of the plane. Not collective. Throws UserError for an unknown group, and where the plane cannot be found.
[[nodiscard]] Vec3 mirror_normal(const mesh::SurfaceMesh& mesh, const Support& symmetry);

}  // namespace voile::system

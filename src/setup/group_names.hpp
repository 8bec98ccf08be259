// Names of groups in a case.
#pragma once

#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::setup {

/// Throws UserError that names the section if it names a group that the mesh does not have. `c`: with all of its stages.
void check_group_names(const input::Case& c, const mesh::SurfaceMesh& mesh);

}  // namespace voile::setup

// Names of groups in a case.
#pragma once

#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::setup {

/// The mesh with a group for each list of groups that a key of the case, or of one of its stages, names as one. Throws UserError if those of a
/// list are not of one kind; unknown ones are left to check_group_names().
[[nodiscard]] mesh::SurfaceMesh with_group_unions(const input::Case& c, mesh::SurfaceMesh mesh);

/// Throws UserError that names the section if it names a group that the mesh does not have. `c`: with all of its stages.
void check_group_names(const input::Case& c, const mesh::SurfaceMesh& mesh);

}  // namespace voile::setup

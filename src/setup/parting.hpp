// Where a sheet ends within the mesh: along hinges, and round what a clamped surface holds, at whose border the slope is held.
#pragma once

#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::setup {

/// The mesh with joints there (surface_mesh.hpp). Not round clamped surfaces where joints are not possible, which its notes tell. Not
/// collective. Throws UserError as SurfaceMesh().
[[nodiscard]] mesh::SurfaceMesh parted(const input::Case& c, mesh::SurfaceMesh whole);

}  // namespace voile::setup

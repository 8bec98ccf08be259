// What a user should know of the hinges of a case on its mesh.
#pragma once

#include <string>
#include <vector>

#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::setup {

/// Of hinges on the boundary where nothing holds the sheet. Throws UserError as system::edges_of().
[[nodiscard]] std::vector<std::string> hinge_warnings(const input::Case& c, const mesh::SurfaceMesh& mesh);

}  // namespace voile::setup

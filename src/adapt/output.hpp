// The mesh that the changed triangulation is.
#pragma once

#include "surface.hpp"

namespace voile::adapt {

[[nodiscard]] Remeshed make_output(const Surface& s, const mesh::SurfaceMesh& old_mesh);

}  // namespace voile::adapt

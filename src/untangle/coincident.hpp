// Pieces of the sheet that lie exactly in one another; private to src/untangle.
#pragma once

#include "tangle.hpp"

namespace voile::untangle {

/// Parts points that lie on triangles of another piece of the sheet: half the wanted distance each, along the normal of
/// the piece that comes first in the mesh.
void part_coincident(Tangle& tangle);

}  // namespace voile::untangle

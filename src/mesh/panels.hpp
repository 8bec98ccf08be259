// The flat panels that a garment is sewn from as its rest shape: texture coordinates whose unit is a length.
//
// Symbols   (u, v)  texture coordinates of a corner;  rest position X = unit (u, v, 0)
// The texture coordinates of every triangle turn as its corners do, seen from the side its normal points to.
#pragma once

#include <string>
#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

/// Makes the texture coordinates the rest shape; unit [m] > 0. Not collective.
/// Throws UserError if there are none at some triangle, if triangles have no area there, or if their area is so far from
/// that of the positions that the unit must be wrong.
void take_rest_from_texture(MeshData& data, double unit);

/// Throws UserError if panels are mirrored. Not collective.
void check_panels(const SurfaceMesh& mesh);

/// What a user should know of the seams: how many edges they have, and by how much their sides differ in length. Empty
/// without charts.
[[nodiscard]] std::vector<std::string> seam_notes(const SurfaceMesh& mesh);

}  // namespace voile::mesh

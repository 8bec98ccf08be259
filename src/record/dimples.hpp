// Whether single vertices of a shell are pressed in or out between their neighbours.
//
// Symbols   w_v   displacement of vertex v along the normal of the surface at the start                               [m]
//           m_v   mean of the neighbours of v, those within the surface twice, so that a plane of symmetry mirrors them
//   depth = max |w_v - m_v| / max |u|.  The corrected membrane leaves dimples of the size of a cell to bending alone. Where
//   cells are larger than sqrt(R h), a load that is shared out by triangles brings them about, and they may be larger than
//   what is right, with little energy (docs/verification/limits.md): no estimate that is relative to the energy sees them.
#pragma once

#include <string>
#include <vector>

#include "energy/sheet.hpp"
#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::record {

/// Depth from which on the run warns: the finest waves that a mesh resolves, of eight cells, have 0.3 of theirs.
inline constexpr double depth_limit = 0.5;

struct Dimple {
  double depth = 0.0;
  Index vertex = no_index;
};

/// The deepest of all vertices but those on the boundary that `mirrored` does not name. `displacement`: three components per vertex in
/// global axes [m]. Not collective.
[[nodiscard]] Dimple deepest_dimple(const mesh::SurfaceMesh& mesh, const std::vector<char>& mirrored,
                                    const std::vector<double>& displacement);

/// What to warn of in a state of a sheet; empty: nothing, as wherever no pressure acts, or in motion, or with another membrane than the
/// corrected one. Likewise.
[[nodiscard]] std::string dimple_warning(const input::Case& c, const energy::Sheet& sheet,
                                         const std::vector<double>& displacement, double load_factor);

}  // namespace voile::record

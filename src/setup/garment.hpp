// The mesh of a case: from a file, or cut from the pieces of a pattern.
#pragma once

#include <string>

#include "base/mpi.hpp"
#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::setup {

/// Its seams are those that some stage sews. Collective. Throws UserError on every rank.
[[nodiscard]] mesh::SurfaceMesh case_mesh(MPI_Comm comm, const input::Case& c);

/// Panels, seams and fabric of a case that has them, on rank 0; otherwise empty. Collective.
[[nodiscard]] std::string garment_report(MPI_Comm comm, const input::Case& c);

}  // namespace voile::setup

// The rest shape of a case with [form]: where the prestress of its materials and the forces of its cables are in equilibrium.
#pragma once

#include "base/mpi.hpp"
#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::setup {

/// The mesh of the case in its form (form_finding.hpp), under the supports of its first stage. Collective. Throws UserError on
/// every rank where no form is found, a group is missing or a piece is not held.
[[nodiscard]] mesh::SurfaceMesh with_form(MPI_Comm comm, const input::Case& c, mesh::SurfaceMesh mesh);

}  // namespace voile::setup

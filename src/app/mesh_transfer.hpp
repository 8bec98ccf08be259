// Meshes from rank 0 to all; private to src/app.
#pragma once

#include "base/mpi.hpp"

#include "mesh/surface_mesh.hpp"

namespace voile::app {

/// Replaces `data` on every rank by that of rank 0, without its notes. Collective.
void broadcast_mesh(MPI_Comm comm, mesh::MeshData& data);

}  // namespace voile::app

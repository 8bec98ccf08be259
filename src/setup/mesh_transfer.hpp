// Meshes from rank 0 to all.
#pragma once

#include <filesystem>

#include "base/mpi.hpp"
#include "formats/mesh_file.hpp"

#include "mesh/surface_mesh.hpp"

namespace voile::setup {

/// Replaces `data` on every rank by that of rank 0, without its notes. Collective.
void broadcast_mesh(MPI_Comm comm, mesh::MeshData& data);

/// Reads a mesh on rank 0 and distributes it. Collective. Throws UserError on every rank.
[[nodiscard]] mesh::SurfaceMesh load_mesh(MPI_Comm comm, const std::filesystem::path& file,
                                          const formats::MeshOptions& options);

}  // namespace voile::setup

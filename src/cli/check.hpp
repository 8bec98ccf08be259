// Reports on a case or a mesh without solving. All are collective over the communicator that they are given, throw on every
// rank and print on rank 0 only.
#pragma once

#include "base/mpi.hpp"
#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::cli {

/// Builds everything that a run would build and reports it, without solving. Throws UserError if anything is wrong.
void check(MPI_Comm comm, const input::Case& c);

/// Sizes, groups, quality, partition balance and patch condition numbers of a mesh (.msh, .geo) or of a case's mesh.
void info(MPI_Comm comm, const mesh::SurfaceMesh& mesh, const energy::ElementOptions& element);

}  // namespace voile::cli

// States to continue from.
#pragma once

#include "input/case.hpp"
#include "mesh/surface_mesh.hpp"
#include "record/run_options.hpp"
#include "remesh/epoch.hpp"
#include "results/checkpoint.hpp"

namespace voile::simulation {

using remesh::Origin;

/// Displacements from the mesh to the shape of `mesh.start`, three per vertex in mesh order, on rank 0; empty if the
/// case has none. Collective. Throws UserError if that file holds another mesh.
[[nodiscard]] std::vector<double> start_shape(MPI_Comm comm, const input::Case& c, const mesh::SurfaceMesh& mesh);

/// The mesh of what --restart names if remeshing has made it, otherwise `first`, that of the case. Collective. Throws
/// UserError if the file cannot be read.
[[nodiscard]] std::shared_ptr<const mesh::SurfaceMesh> mesh_of_start(const input::Case& c,
                                                                     const record::RunOptions& options,
                                                                     std::shared_ptr<const mesh::SurfaceMesh> first);

/// The start of a run: the mesh at rest, the shape of `mesh.start`, or what --restart names, a results file or a
/// checkpoint. A motion continues from the step of a motion at its time, from anything else it begins at time 0; a path
/// continues from an equilibrium at its load factor. Arrays on rank 0 only. Collective. Throws UserError if the file does
/// not fit.
[[nodiscard]] results::Checkpoint read_start(const input::Case& c, const record::RunOptions& options,
                                             const mesh::SurfaceMesh& mesh, Origin origin);

/// Prepares a state for the stage it enters: steps are counted and chosen from the beginning, a path begins at load
/// factor 0 under what has acted before, a motion that begins at rest gets the case's initial velocities. Collective.
/// Throws UserError.
void enter_stage(MPI_Comm comm, const input::Case& c, const mesh::SurfaceMesh& mesh, Origin origin,
                 results::Checkpoint& state);

}  // namespace voile::simulation

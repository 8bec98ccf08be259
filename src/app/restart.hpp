// States to go on from; private to src/app.
#pragma once

#include "voile/app/run.hpp"
#include "voile/input/case.hpp"
#include "voile/io/checkpoint.hpp"
#include "voile/solve/static_path.hpp"
#include "voile/system/model.hpp"

namespace voile::app {

/// A state that --restart names, scattered into unknowns.
struct Restart {
  bool given = false;
  bool from_motion = false;  ///< not in equilibrium
  petsc::VecHandle previous;
  solve::PathStart start;
};

/// Displacements from the mesh to the shape of `mesh.start`, three per vertex in mesh order, on rank 0; empty if the case
/// has none. Collective. Throws UserError if that file holds another mesh.
[[nodiscard]] std::vector<double> start_shape(const input::Case& c, const mesh::SurfaceMesh& mesh);

/// Start of everything but a motion, from `mesh.start` or a results.h5 or a checkpoint.h5; `a` becomes its state. Collective. Throws
/// UserError if the file does not fit.
[[nodiscard]] Restart read_restart(const input::Case& c, const RunOptions& options, const system::Model& model, Vec a);

/// Start of a motion, arrays on rank 0 only. A checkpoint.h5, or a step of a motion's results.h5, is gone on from at
/// its time; from a step without velocities, an equilibrium, a motion begins at time 0. Without the option: in the shape
/// of `mesh.start`, at rest or with the case's initial velocities. Collective. Throws UserError if the file does not fit.
[[nodiscard]] io::Checkpoint read_start(const input::Case& c, const RunOptions& options, const system::Model& model);

}  // namespace voile::app

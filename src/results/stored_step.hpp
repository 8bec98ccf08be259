// Reads a step of results.vtkhdf back, to continue from it.
#pragma once

#include <filesystem>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::results {

struct StoredStep {
  int step = 0;
  double load_factor = 0.0, time = 0.0;
  bool in_motion = false;            ///< whether its run was a motion, whatever fields it recorded
  std::vector<double> displacement;  ///< vertices x 3, global axes, mesh order [m]
  std::vector<double> velocity;      ///< of a motion, else empty [m/s]
  std::vector<double> path;          ///< of a path: what its next step needs (system::path_record); else empty
  std::vector<double> bodies;        ///< of rigid groups: system::rigid_record; else empty
  std::vector<double> previous;      ///< of the step stored before on the same mesh, empty if there is none [m]
  bool has_last = false;             ///< whether that is the step before
};

/// Reads step number `step`, or the last one if negative. Not collective: root only.
/// The run may be finished, going on or killed: steps that results.vtkhdf does not name yet are found in steps/.
/// Throws UserError if the file cannot be read, belongs to another mesh, or lacks the step or its displacement, also
/// because its file in steps/ is missing or damaged.
[[nodiscard]] StoredStep read_step(const std::filesystem::path& file, int step, const mesh::SurfaceMesh& mesh);

/// The shape of a mode, vertices x 3 in global axes, from the modes/results.vtkhdf of a run on the same mesh. Not collective: root
/// only. Throws UserError if the file cannot be read, belongs to another mesh, or lacks the mode.
[[nodiscard]] std::vector<double> read_mode(const std::filesystem::path& file, int number,
                                            const mesh::SurfaceMesh& mesh);

/// The mesh of step number `step`, or of the last one if negative, as it was written: positions at rest, triangles,
/// groups, texture and the numbers that vertices and triangles had in their file; no notes. Not collective: root only.
/// Throws UserError as read_step does.
[[nodiscard]] mesh::MeshData read_step_mesh(const std::filesystem::path& file, int step);

/// Whether step number `step`, or the last one if negative, is on another mesh than the first step of its run. Not
/// collective: root only. Throws UserError as read_step does.
[[nodiscard]] bool is_remeshed(const std::filesystem::path& file, int step);

/// Whether a file is a results.vtkhdf rather than a checkpoint. Not collective: root only.
[[nodiscard]] bool is_results(const std::filesystem::path& file);

}  // namespace voile::results

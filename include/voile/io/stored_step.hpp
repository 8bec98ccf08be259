// Reads a step of results.h5 back, to go on from it.
#pragma once

#include <filesystem>
#include <vector>

#include "voile/mesh/surface_mesh.hpp"

namespace voile::io {

struct StoredStep {
  int step = 0;
  double load_factor = 0.0, time = 0.0;
  std::vector<double> displacement;  ///< vertices x 3, global axes, mesh order [m]
  std::vector<double> velocity;      ///< of a motion, else empty [m/s]
  std::vector<double> previous;      ///< of the step stored before, empty if there is none [m]
};

/// Reads step number `step`, or the last one if negative. Not collective: root only.
/// Throws UserError if the file cannot be read, belongs to another mesh, or lacks the step or its displacement, also
/// because the file in steps/ that it links to is missing. Steps that results.h5 does not name yet are found in steps/.
[[nodiscard]] StoredStep read_step(const std::filesystem::path& file, int step, const mesh::SurfaceMesh& mesh);

/// Whether a file is a results.h5 rather than a checkpoint. Not collective: root only.
[[nodiscard]] bool is_results(const std::filesystem::path& file);

}  // namespace voile::io

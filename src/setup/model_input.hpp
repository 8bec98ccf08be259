// From the case to what a model is built from.
#pragma once

#include <vector>

#include "input/case.hpp"
#include "obstacles.hpp"
#include "system/model.hpp"

namespace voile::setup {

/// What [sewing] and [[seam]] say of seams; none without panels.
[[nodiscard]] std::vector<system::SeamRule> seam_rules(const input::Case& c);

/// Reads the files of obstacles that are not known yet. Collective. Throws UserError.
[[nodiscard]] system::ModelInput model_input(MPI_Comm comm, const input::Case& c, KnownObstacles& known);

/// Least membrane stiffness along a material axis of all materials [N/m]. Not collective.
[[nodiscard]] double softest_membrane(const input::Case& c);

}  // namespace voile::setup

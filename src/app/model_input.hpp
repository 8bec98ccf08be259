// From the case to what a model is built from; private to src/app.
#pragma once

#include <vector>

#include "obstacles.hpp"
#include "voile/input/case.hpp"
#include "voile/system/model.hpp"

namespace voile::app {

/// Reads the files of obstacles that are not known yet. Collective. Throws UserError.
/// What [sewing] and [[seam]] say of seams; none without panels.
[[nodiscard]] std::vector<system::SeamRule> seam_rules(const input::Case& c);

[[nodiscard]] system::ModelInput model_input(MPI_Comm comm, const input::Case& c, KnownObstacles& known);

}  // namespace voile::app

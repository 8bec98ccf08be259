// From the case to what a model is built from; private to src/app.
#pragma once

#include <vector>

#include "voile/input/case.hpp"
#include "voile/system/model.hpp"

namespace voile::app {

/// Reads the files of obstacles. Collective. Throws UserError.
[[nodiscard]] system::ModelInput model_input(const input::Case& c);

}  // namespace voile::app

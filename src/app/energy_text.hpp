// The balance of a motion's energy in words; private to src/app.
#pragma once

#include <string>

#include "voile/system/energy_balance.hpp"

namespace voile::app {

/// One line for the end of a run.
[[nodiscard]] std::string balance_text(const system::EnergyBalance& balance);

}  // namespace voile::app

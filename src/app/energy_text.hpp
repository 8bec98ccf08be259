// The balance of a motion's energy as columns and in words; private to src/app.
#pragma once

#include <array>
#include <string>
#include <utility>

#include "voile/system/energy_balance.hpp"

namespace voile::app {

/// The columns of history.csv besides `kinetic_energy` [J].
[[nodiscard]] std::array<std::pair<const char*, double>, 10> named_parts(const system::EnergyBalance& balance);
/// One line for the end of a run.
[[nodiscard]] std::string balance_text(const system::EnergyBalance& balance);

}  // namespace voile::app

// Rims of gases that move, said to the user.
#pragma once

#include <string>
#include <vector>

#include "input/case.hpp"
#include "system/model.hpp"

namespace voile::setup {

/// A note where a gas has `added_volume` behind a rim that supports do not hold: the fan that closes a rim goes with it, a rigid
/// box would not. Empty if there is none. Not collective: the same on every rank.
[[nodiscard]] std::vector<std::string> moving_rims(const input::Case& c, const system::Model& model);

}  // namespace voile::setup

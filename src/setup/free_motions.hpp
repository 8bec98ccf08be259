// Rigid-body motions that nothing holds, said to the user.
#pragma once

#include <string>
#include <vector>

#include "input/case.hpp"
#include "system/model.hpp"

namespace voile::setup {

/// Notes about pieces that the supports do not hold, for the user; empty if all are held. Not collective: the same on
/// every rank.
/// Throws UserError where no equilibrium can be unique: free translations in statics without contact, and any free
/// motion with analysis = "linear" or "buckling".
[[nodiscard]] std::vector<std::string> check_free_motions(const input::Case& c, const system::Model& model);

}  // namespace voile::setup

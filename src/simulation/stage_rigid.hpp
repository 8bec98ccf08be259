// Rigid groups from one stage to the next: they stay rigid, and are held and moved from where they are.
#pragma once

#include <string>
#include <vector>

#include "remesh/stage.hpp"

namespace voile::simulation {

/// Puts the groups of a stage in the order of those before, and holds what has moved or grown there; `factor`: what that stage has
/// scaled its loads by at its end. `before`: null for a stage that begins anew. Returns what a user should know. Not collective.
/// Throws UserError for groups that are not rigid in both stages, and motions where nothing moves.
std::vector<std::string> hold_over_rigids(const remesh::Stage* before, double factor, remesh::Stage& now);

}  // namespace voile::simulation

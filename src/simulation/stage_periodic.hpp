// Pairs of periodic edges from one stage to the next: they stay pairs, and are held and pulled from where they are.
#pragma once

#include "remesh/stage.hpp"

namespace voile::simulation {

/// Puts the pairs of a stage in the order of those before, and holds what has moved or grown there; `factor`: what that stage has
/// scaled its loads by at its end. `before`: null for a stage that begins anew. Not collective. Throws
/// UserError for edges that are no pair in both stages, and differences that grow where nothing moves them.
void hold_over_periodics(const remesh::Stage* before, double factor, remesh::Stage& now);

}  // namespace voile::simulation

// Obstacles from one stage to the next: whether the time or a load factor moves them.
#pragma once

#include <vector>

#include "remesh/stage.hpp"

namespace voile::simulation {

/// An obstacle that some stage moves in time stands still in the others. One of which no stage is in time moves by the load
/// factor of its first path, and stays where that has brought it. `all`: of the case; `now`: with its obstacles. Not collective.
void lead_obstacles(const std::vector<input::Case>& all, remesh::Stage& now);

}  // namespace voile::simulation

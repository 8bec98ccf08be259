// What a weld leaves folded sharply unfolds before motion begins.
#pragma once

#include <string>
#include <vector>

#include "remesh/epoch.hpp"
#include "system/dynamics_options.hpp"

namespace voile::simulation {

using remesh::Epoch;

/// Lets the fabric along newly welded seams unfold without motion, a few cells far, as long as that sets energy free, and
/// enters what it has set free in the balance of energy. Velocities stay. Says what it did; empty if nothing is to be done.
/// For a stage in time. Collective.
[[nodiscard]] std::string settle_weld(Epoch& epoch, const std::vector<std::string>& seams,
                                      const system::DynamicsOptions& dynamics);

}  // namespace voile::simulation

// What keeps the two sides of a seam apart; private to src/app.
#pragma once

#include <string>
#include <vector>

#include "voile/mesh/surface_mesh.hpp"
#include "voile/system/contact.hpp"

namespace voile::app {

/// What lies on the straight ways between points of a seam that are further apart than `gap`: obstacles and pieces by name, and at
/// how many of these places; empty if nothing does. `positions`: of all points of the contact [m]. Not collective.
[[nodiscard]] std::string obstruction_text(const system::ContactScene& scene, const std::vector<Vec3>& positions,
                                           const std::string& seam, double gap);

}  // namespace voile::app

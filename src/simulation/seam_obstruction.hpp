// What keeps the two sides of a seam apart.
#pragma once

#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"
#include "system/contact.hpp"

namespace voile::simulation {

/// What lies on the straight ways between points of seams that are further apart than `gap`, for the seam with most such
/// places: obstacles and pieces by name; empty if nothing does. `positions`: of all points of the contact [m]. Not collective.
[[nodiscard]] std::string obstruction_text(const system::ContactScene& scene, const std::vector<Vec3>& positions,
                                           const std::vector<std::string>& seams, double gap);

}  // namespace voile::simulation

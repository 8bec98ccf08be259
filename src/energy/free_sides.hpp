// Slopes of free sides, which minimise the bending energy; private to src/energy.
#pragma once

#include <vector>

#include "base/types.hpp"

namespace voile::energy {

/// Projector that condenses the slopes of free sides: kappa = P kappa'' with M_nn = 0 on each of them. `free_sides`: their n (x) n as
/// (k11, k22, 2 k12), of any length; `bending`: D.
[[nodiscard]] Mat3 condense_free_sides(const std::vector<Vec3>& free_sides, const Mat3& bending);

}  // namespace voile::energy

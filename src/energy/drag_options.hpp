// Parameters of air drag; symbols in drag.hpp.
#pragma once

#include "base/types.hpp"

namespace voile::energy {

struct DragOptions {
  double air_density = 1.2;  ///< rho [kg/m^3]
  double normal = 0.0;       ///< C_n
  double tangential = 0.0;   ///< C_t
  Vec3 wind = Vec3::Zero();  ///< w [m/s]
  [[nodiscard]] bool active() const { return normal > 0.0 || tangential > 0.0; }
};

}  // namespace voile::energy

// Parameters of air drag; symbols in drag.hpp.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace voile::energy {

struct DragOptions {
  double air_density = 1.2;  ///< rho [kg/m^3]
  double normal = 0.0;       ///< C_n
  double tangential = 0.0;   ///< C_t
  Vec3 wind = Vec3::Zero();  ///< w, at t = 0 if it changes [m/s]
  /// w at time t [s]; empty: it does not change. And the texts it was written as.
  std::function<Vec3(double time)> wind_in_time;
  std::vector<std::string> wind_texts{"0", "0", "0"};
  [[nodiscard]] bool active() const { return normal > 0.0 || tangential > 0.0; }
};

}  // namespace voile::energy

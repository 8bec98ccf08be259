// Forces of a hyperelastic sheet whose work is done on stretches, for estimates of error.
//
// Symbols   U   root of C, N = dw/dE (hyperelastic.hpp);  l_i, n_i  its stretches and axes
//   B = U N, of principal values f_i = l_i N_i,   d2w/dl_i dl_j = N_i delta_ij + l_i l_j (n_i n_i).T.(n_j n_j),   T = d2w/dE2
// Differences of N tell little where a sheet is stretched much: N of neo-Hooke tends to a constant.
#pragma once

#include "hyperelastic.hpp"

namespace voile::energy {

struct BiotForce {
  Vec3 force = Vec3::Zero();  ///< B in material axes [N/m]
  double softness = 0.0;      ///< f.H^-1 f, H the second derivatives by stretches; 0 where these are not positive [N/m]
};
[[nodiscard]] BiotForce biot_force(const Hyperelastic& law, const Vec3& strain);

}  // namespace voile::energy

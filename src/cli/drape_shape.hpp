// What a drape tester reads off a specimen: the shadow, and the folds of its edge.
//
// Symbols   r(a)   distance of the shadow's rim from the axis in direction a, the largest over the sheet                 [m]
//           R_s    radius of the support [m];  A = 1/2 int r^2 da, A_0 the same of the flat specimen                  [m^2]
//   drape coefficient = (A - pi R_s^2) / (A_0 - pi R_s^2)
// A fold is a maximum of r between two minima that lie lower by more than a tenth of the range of r, and by more than 0.3 mm.
#pragma once

#include <vector>

#include "base/types.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::cli {

struct DrapeFold {
  double angle = 0.0;       ///< of its tip about the axis [rad]
  double amplitude = 0.0;   ///< of r, from the mean of the minima beside it to the tip [m]
  double wavelength = 0.0;  ///< angle between these minima [rad]
};

struct DrapeShape {
  double coefficient = 0.0;
  std::vector<DrapeFold> folds;                                  ///< by angle
  double amplitude_variation = 0.0, wavelength_variation = 0.0;  ///< standard deviation over mean; 0: folds are alike
  std::vector<double> radius;                                    ///< r in directions of equal distance, from 0 on [m]
};

/// r in `count` directions of the triangles at these places, in plan view about the origin; 0 where there are none. Not collective.
[[nodiscard]] std::vector<double> shadow_radius(const std::vector<mesh::Triangle>& triangles,
                                                const std::vector<Vec3>& places, std::size_t count);
/// Folds of a closed curve r. Not collective.
[[nodiscard]] std::vector<DrapeFold> folds_of(const std::vector<double>& radius);
/// The specimen that was flat at `flat` and is at `places` now. Not collective.
[[nodiscard]] DrapeShape drape_shape(const std::vector<mesh::Triangle>& triangles, const std::vector<Vec3>& flat,
                                     const std::vector<Vec3>& places, double support_radius);

}  // namespace voile::cli

// How far an iteration may go with contact; private to src/solve.
#pragma once

#include <algorithm>
#include <cmath>

#include "voile/system/contact.hpp"
#include "voile/system/model.hpp"

namespace voile::solve {

/// With contact, an iteration moves no vertex by more than so many cells: longer increments are far from the truth, and
/// expensive to look for collisions along.
inline constexpr double trusted_cells = 4.0;

/// Share of the increment -y that contact lets state x take; 1 without contact. `scratch` is overwritten. Collective.
inline double allowed_fraction(system::Model& model, Vec x, Vec y, Vec scratch) {
  if (!model.contact()) return 1.0;
  const double cell = std::sqrt(model.discretisation().mean_area());
  double largest = 0.0;
  VOILE_PETSC(VecNorm(y, NORM_INFINITY, &largest));
  const double trusted = std::min(1.0, trusted_cells * cell / std::max(largest, 1e-300));
  VOILE_PETSC(VecCopy(y, scratch));
  VOILE_PETSC(VecScale(scratch, -trusted));
  return trusted * model.contact()->step_fraction(x, scratch);
}

}  // namespace voile::solve

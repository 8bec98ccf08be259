// How far an iteration may go with contact; private to src/solve.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "system/contact.hpp"
#include "system/model.hpp"

namespace voile::solve {

/// With contact, an iteration moves no vertex by more than so many cells: longer increments are far from the truth, and
/// expensive to look for collisions along.
inline constexpr double trusted_cells = 4.0;

/// A step turns no clamp by more than so much [rad]: the first iteration moves what it holds along tangents, which strains
/// the cells there by about half the square of the angle. Newton's method found wrong states, or none, from 45 degrees on.
inline constexpr double largest_turn = 20.0 * std::numbers::pi / 180.0;

/// The first part of a step between two times (or load factors) in which no clamp turns by more than that, as a fraction.
/// Not collective.
inline double fraction_by_turn(const system::Model& model, double from, double to, bool by_load) {
  double fraction = 1.0;
  for (int k = 0; k < 60; ++k) {
    const double turn = model.conditions().turn_between(from, from + fraction * (to - from), by_load);
    if (turn <= 1.0001 * largest_turn) break;
    fraction *= std::clamp(largest_turn / turn, 0.1, 0.9);
  }
  return fraction;
}

/// The same, in which no obstacle goes farther than a step of the sheet may, nor leaves it behind. Not collective.
inline double fraction_by_obstacles(const system::Model& model, double from, double to) {
  const double cell = std::sqrt(model.discretisation().mean_area());
  double fraction = 1.0;
  for (int k = 0; k < 60; ++k) {
    const double way =
        model.contact()->scene().way_of_obstacles(from, from + fraction * (to - from), cell, trusted_cells);
    if (way <= 1.0001) break;
    fraction *= std::clamp(1.0 / way, 0.1, 0.9);
  }
  return fraction;
}

/// Fraction of the increment -y that contact lets state x take; 1 without contact. `scratch` is overwritten. Collective.
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

/// Takes `next` back towards x where a line search went beyond its increment and contact does not allow it; true if it
/// did. Collective.
inline bool hold_back(system::Model& model, SNESLineSearch search, Vec x, Vec next) {
  double length = 1.0;
  VOILE_PETSC(SNESLineSearchGetLambda(search, &length));
  if (!(length > 1.0)) return false;
  const petsc::VecHandle back = model.dofs().create_vector(), scratch = model.dofs().create_vector();
  VOILE_PETSC(VecWAXPY(back, -1.0, next, x));
  const double fraction = allowed_fraction(model, x, back, scratch);
  if (fraction >= 1.0) return false;
  VOILE_PETSC(VecWAXPY(next, -fraction, back, x));
  return true;
}

}  // namespace voile::solve

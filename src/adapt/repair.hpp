// Patches whose six points lie near a conic, found and mended.
#pragma once

#include "operations.hpp"
#include "surface.hpp"

namespace voile::adapt {

/// Condition above which the element does not use a patch.
inline constexpr double largest_condition = 30.0;

/// Condition of the quadratic through the six points of triangle t's patch, as energy/curvature.hpp has it; 0 where a
/// neighbour is missing.
[[nodiscard]] double patch_condition(const Surface& s, Index t);

/// Mends what can be mended: inner vertices of three triangles removed, edges turned, vertices moved.
void repair(Surface& s, const Options& options);

/// try_move, taken back if a patch around gets ill conditioned by it, or worse than it was.
Outcome try_move_well(Surface& s, const Star& star, const Fan& fan, const Vec2& target, double angle);

[[nodiscard]] Quality quality_of(const Surface& s);

}  // namespace voile::adapt

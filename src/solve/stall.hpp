// Where an iteration got stuck, in words.
#pragma once

#include <string>

#include "system/model.hpp"

namespace voile::solve {

/// "the residual is largest at triangle 12 at (x, y, z), smallest angle 0.6 degrees; ...": up to three triangles,
/// ranked by the sum of |r| over their corners, apart from each other, with their centroids at rest. A residual that is
/// not finite counts as the largest. Empty if r is zero. Collective; the text is the same on every rank.
[[nodiscard]] std::string largest_residuals(const system::Model& model, Vec r);

/// The same for the residual of the model at state a, and of hyperelastic sheets the largest stretch. Collective.
[[nodiscard]] std::string largest_residuals_at(system::Model& model, Vec a);

}  // namespace voile::solve

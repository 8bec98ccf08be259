// Where an iteration got stuck, in words.
#pragma once

#include <string>

#include "system/model.hpp"

namespace voile::solve {

/// "the residual is largest at triangle 12 at (x, y, z), smallest angle 0.6 degrees; ...": up to three triangles,
/// ranked by the sum of |r| over their corners, apart from each other, with their centroids at rest. A residual that is
/// not finite counts as the largest. Empty if r is zero. Collective; the text is the same on every rank.
[[nodiscard]] std::string largest_residuals(const system::Model& model, Vec r);

/// "; the largest stretch is 4.2, of triangle 12 at (x, y, z)", and where a hyperelastic law has lost ellipticity; empty if there is none.
/// Collective.
[[nodiscard]] std::string largest_stretch(system::Model& model, Vec a);

/// Both, of the residual of the model at state a. Collective.
[[nodiscard]] std::string largest_residuals_at(system::Model& model, Vec a);

}  // namespace voile::solve

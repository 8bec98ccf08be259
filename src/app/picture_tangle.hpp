// The picture of triangles that intersect, for the solver, which draws nothing itself; private to src/app.
#pragma once

#include <string>

namespace voile::app {

/// Draws what a message holds (IntersectionCheck::draw) into a PNG. Returns nothing.
[[nodiscard]] std::string draw_tangle(const std::string& message, const std::string& picture);

}  // namespace voile::app

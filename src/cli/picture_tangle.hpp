// The picture of triangles that intersect, for the solver, which draws nothing itself.
#pragma once

#include <string>

namespace voile::cli {

/// Draws what a message holds (IntersectionCheck::draw) into a PNG. Returns nothing.
[[nodiscard]] std::string draw_tangle(const std::string& message, const std::string& picture);

}  // namespace voile::cli

// Post-processing views of Gmsh (.pos) as fields of a place.
#pragma once

#include <string>
#include <vector>

#include "base/types.hpp"

namespace voile::formats {

/// Values of the scalar view of a .pos file, at its first step, at points in the file's coordinates; by Gmsh's own
/// interpolation, and at points outside of all of its elements, as near a curved surface, the value of its nearest node.
/// Not collective: call on one rank. Throws UserError for a missing or damaged file, commands that would write files or
/// start programs, and unless it has exactly one view, of numbers.
[[nodiscard]] std::vector<double> view_values(const std::string& file, const std::vector<Vec3>& points);

}  // namespace voile::formats

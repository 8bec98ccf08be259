// Outlines of the surfaces of a Gmsh script, in the program voile-gmsh.
#pragma once

#include <string>
#include <vector>

namespace voile::formats {

/// `words`: what read_geo_faces() gave (src/formats/geo_outline.cpp): program, file, "outlines", then names and values of parameters. Returns the faces
/// as bytes. Throws UserError if there is no surface, or none with closed loops.
[[nodiscard]] std::string outlines_of(const std::vector<std::string>& words);

}  // namespace voile::formats

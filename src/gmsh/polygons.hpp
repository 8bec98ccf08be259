// Fills plane polygons with triangles, in the program voile-gmsh.
#pragma once

#include <string>

namespace voile::formats {

inline constexpr int triangle_type = 2;  ///< Gmsh's number for it

/// `file`: what mesh_polygons() wrote (src/formats/gmsh_polygon.cpp). Returns the triangulations as bytes, one after the other.
/// Throws UserError if a polygon cannot be meshed.
[[nodiscard]] std::string fill_polygons(const std::string& file);

}  // namespace voile::formats

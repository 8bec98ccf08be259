// Triangles of an obstacle, read from a file.
#pragma once

#include <filesystem>

#include "geometry/primitive_surface.hpp"

namespace voile::formats {

/// Reads .obj, .stl (binary and ASCII), .ply (both), .off (ASCII) and Gmsh's .msh; the extension decides (.msh in
/// small letters). Polygons of more than three corners are split into triangles. Vertices keep the file's numbers, also
/// those without a triangle, so that a point cache fits; an STL file has no vertex numbers: there corners of identical
/// coordinates become one vertex, numbered as they appear; of a .msh only vertices of triangles remain.
/// Not collective; the caller owns the result. Throws UserError that names the file if it is missing, unreadable, cut
/// short or of another kind, has no triangle of non-zero area, coordinates that are not finite, or vertex numbers that
/// do not exist.
[[nodiscard]] geometry::TriangleSoup read_triangles(const std::filesystem::path& file);

}  // namespace voile::formats

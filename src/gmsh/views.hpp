// Values of Gmsh's views; private to the program voile-gmsh.
#pragma once

#include <string>

namespace voile::formats {

/// For src/formats/gmsh_view.cpp: reads its message, answers with a value for each point as bytes. Throws UserError.
[[nodiscard]] std::string view_at_points(const std::string& message_file);

}  // namespace voile::formats

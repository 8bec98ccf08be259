// What libvoile-gmsh exports to src/io/gmsh.cpp, which loads it when a file needs it: both are parts of one build.
#pragma once

#include <string>

#include "voile/io/gmsh.hpp"

namespace voile::io::gmsh_module {

enum class Answer { done, user_error, gmsh_error, no_memory, failed };

inline constexpr const char *file_name = "libvoile-gmsh.so", *read_name = "voile_gmsh_read",
                            *version_name = "voile_gmsh_version";

/// A mesh as bytes (mesh_bytes.hpp), or what was wrong, in `text`.
using Read = Answer(const std::string& file, const MeshOptions& options, bool is_geo, std::string& text);
using Version = Answer(std::string& text);

}  // namespace voile::io::gmsh_module

#define VOILE_GMSH_EXPORT extern "C" __attribute__((visibility("default")))

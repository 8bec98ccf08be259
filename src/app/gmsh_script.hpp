// Scripts of Gmsh (.geo) with their parameters, in the program voile-gmsh. Needs a Session.
#pragma once

#include <map>
#include <string>

namespace voile::io {

/// Throws UserError if Gmsh has logged errors so far. `doing`: a word for the message.
void check_log(const std::string& file, const char* doing);

/// Reads a script, its parameters preset. Throws UserError that names a parameter that is not there, and what Gmsh complains of.
void open_geo(const std::string& file, const std::map<std::string, double>& parameters);

/// Name of a physical group, or its kind and number.
[[nodiscard]] std::string group_name(int dimension, int tag);

}  // namespace voile::io

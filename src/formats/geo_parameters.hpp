// Which parameters a Gmsh script (.geo) lets its user set. Gmsh cannot be asked: it passes over unknown names in
// silence.
#pragma once

#include <map>
#include <string>

namespace voile::formats {

/// Variable -> its ONELAB name, through which it must be set, or "" if the variable itself can be set beforehand.
using GeoParameters = std::map<std::string, std::string>;

/// Variables in DefineConstant, DefineNumber and Exists of a script and of the scripts it includes. Not collective.
/// Throws UserError if a script cannot be read or would end the whole program (command Exit).
[[nodiscard]] GeoParameters geo_parameters(const std::string& file);

}  // namespace voile::formats

// Keys that --set gives on the command line; private to src/input.
#pragma once

#include <string>
#include <vector>

#include "case_toml.hpp"

namespace voile::input {

/// Puts "mesh.parameters.n=40" into the tables. Throws UserError.
void apply_setting(toml::table& root, const std::string& setting);

}  // namespace voile::input

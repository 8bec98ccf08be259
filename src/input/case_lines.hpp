// Where in a case file a value stands, for what only the mesh shows to be wrong.
#pragma once

#include <filesystem>
#include <string>

namespace voile::input {

/// "FILE:LINE" of the first section of this name, of a stage too, whose key has this text or has it in its list; "FILE" where it is
/// not there, as with --set. Reads the file: not collective.
[[nodiscard]] std::string place_in_case(const std::filesystem::path& file, const std::string& section,
                                        const std::string& key, const std::string& text);

}  // namespace voile::input

// The materials of a case; private to src/input.
#pragma once

#include <filesystem>
#include <vector>

#include "case.hpp"
#include "case_read.hpp"

namespace voile::input {

/// A path as written in a case file. Absolute, so that the echo of the case works from any folder.
[[nodiscard]] std::filesystem::path beside(const std::filesystem::path& case_file, const std::filesystem::path& path);

/// Where the file of a fabric may lie that a case names, in this order: at that path; for a name without folder and ending also
/// as NAME.toml in the folder of the case and among the fabrics that are shipped. Not collective.
[[nodiscard]] std::vector<std::filesystem::path> fabric_places(const std::filesystem::path& case_file,
                                                               const std::filesystem::path& name);

/// Reads every [[material]], with the files of fabrics. Throws UserError for what contradicts itself.
void read_materials(const CaseReader& reader, Case& c);

}  // namespace voile::input

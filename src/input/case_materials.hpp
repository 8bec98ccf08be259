// The materials of a case; private to src/input.
#pragma once

#include <filesystem>

#include "voile/input/case.hpp"
#include "voile/input/case_read.hpp"

namespace voile::input {

/// A path as written in a case file. Absolute, so that the echo of the case works from any folder.
[[nodiscard]] std::filesystem::path beside(const std::filesystem::path& case_file, const std::filesystem::path& path);

/// Reads every [[material]], with the files of fabrics. Throws UserError for what contradicts itself.
void read_materials(const CaseReader& reader, Case& c);

}  // namespace voile::input

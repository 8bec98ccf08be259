// Where what is shipped with Voile lies: its programs, and below share/voile the fabrics, meshes and examples.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace voile {

/// A program of ours: beside the one that runs; or, where a program of somebody else has loaded this code as a library, in a
/// folder above it, or in `bin` there. The path may lead to nothing. Not collective.
[[nodiscard]] std::filesystem::path program_of_ours(const std::string& name);

/// The folder share/voile/NAME of the installation, or of the build that the programs lie in; not collective. Where there is
/// none, the path at which an installation has it.
[[nodiscard]] std::filesystem::path shipped_folder(const std::string& name);

/// Names without ending of the files in a shipped folder that end so, sorted. Not collective.
[[nodiscard]] std::vector<std::string> shipped_names(const std::string& folder, const std::string& ending);

}  // namespace voile

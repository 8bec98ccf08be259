// How a case differs from that of a run which it continues, in what its states are made of.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "case.hpp"

namespace voile::input {

struct SectionDifference {
  std::string section;  ///< its name
  std::string text;     ///< "[section]: keys that differ"
};

/// Sections of sheet and material whose keys differ from those of a resolved case, each with the keys; none if there is no such
/// file. Reads it: not collective.
[[nodiscard]] std::vector<SectionDifference> different_sections(const Case& c, const std::filesystem::path& resolved);

}  // namespace voile::input

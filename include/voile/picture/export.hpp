// Results in the formats of other programs: the sheet, and the bodies that it touches.
//
// Lengths are metres. Axes are those of the run, but glTF's: it demands +y upwards, so what is up in the run is turned to +y.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "voile/picture/recording.hpp"

namespace voile::picture {

struct ExportOptions {
  std::string format;               ///< one of export_formats()
  std::filesystem::path output;     ///< file; where there are several, they get numbers or names after the stem
  std::vector<std::string> fields;  ///< of PLY, CSV and MSH; empty: all that a step has
  double rate = 25.0;               ///< frames per second
  bool bodies = true;
};

[[nodiscard]] const std::vector<std::string>& export_formats();

/// Returns the files written. Throws UserError if a file cannot be written, if there is no such format or field, and if a
/// format whose topology is fixed (PC2, MDD) meets several meshes.
std::vector<std::filesystem::path> export_results(const Recording& recording, const std::vector<Moment>& moments,
                                                  const ExportOptions& options);

}  // namespace voile::picture

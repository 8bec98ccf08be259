// Results in the formats of other programs: the sheet, and the bodies that it touches.
//
// Lengths are metres. Axes are those of the run, but glTF's: it demands +y upwards, so what is up in the run is turned to +y.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cloth.hpp"
#include "recording.hpp"

namespace voile::picture {

struct ExportOptions {
  std::string format;               ///< one of export_formats()
  std::filesystem::path output;     ///< file; where there are several, they get numbers or names after the stem
  std::vector<std::string> fields;  ///< of PLY, CSV and MSH; empty: all that a step has
  double rate = 25.0;               ///< frames per second
  bool bodies = true;
  bool one_mesh = false;  ///< a run that was remeshed is put on one mesh; PC2 and MDD always are
  /// How far vertices of the run may be away from it [m]; by default 5e-4 of the sheet's longest extent at the start.
  std::optional<double> tolerance = std::nullopt;
  ClothChoice cloth{};  ///< of GLB: how the sheet looks
};

struct Exported {
  std::vector<std::filesystem::path> files;
  std::vector<std::string> notes;  ///< for the user: e.g. what putting it on one mesh came to
};

[[nodiscard]] const std::vector<std::string>& export_formats();

/// Throws UserError if a file cannot be written, and if there is no such format or field.
[[nodiscard]] Exported export_results(const Recording& recording, const std::vector<Moment>& moments,
                                      const ExportOptions& options);

}  // namespace voile::picture

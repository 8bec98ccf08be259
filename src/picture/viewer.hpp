// A run as one HTML file that shows it in any browser with WebGL, without a network.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "recording.hpp"

namespace voile::picture {

struct ViewerOptions {
  std::filesystem::path output;
  std::vector<std::string> fields;  ///< NAME or NAME:COMPONENT
  double rate = 12.0;               ///< frames per second when it plays
  bool bodies = true;
};

/// Positions are kept to 1/65535 of the box of the whole motion, fields in single precision. Throws UserError if a field is in
/// no moment or the file cannot be written.
void write_viewer(const Recording& recording, const std::vector<Moment>& moments, const ViewerOptions& options);

}  // namespace voile::picture

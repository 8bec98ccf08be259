// The seam that was open widest before it was welded, of seams.csv.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace voile::picture {

struct WorstSeam {
  std::string name;  ///< as CSV files have it
  double gap = 0.0;  ///< [m]
};

/// Nothing without the file, or without a seam in it. Throws UserError if it is no table of seams.
[[nodiscard]] std::optional<WorstSeam> worst_seam(const std::filesystem::path& seams_csv);

}  // namespace voile::picture

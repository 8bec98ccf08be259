// Columns of a history.csv.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace voile::cli {

using Columns = std::vector<std::vector<double>>;
/// The named columns, in this order; an empty cell is NaN. Throws InternalError without such a column.
[[nodiscard]] Columns read_history(const std::filesystem::path& file, const std::vector<std::string>& names);

}  // namespace voile::cli

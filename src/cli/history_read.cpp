#include "history_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

Columns read_history(const std::filesystem::path& file, const std::vector<std::string>& names) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> head = csv_cells(line);
  Columns columns(names.size());
  while (std::getline(in, line)) {
    const std::vector<std::string> row = csv_cells(line);
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto at = static_cast<std::size_t>(std::find(head.begin(), head.end(), names[k]) - head.begin());
      if (at >= row.size()) throw InternalError(fmt::format("{}: there is no column {}", file.string(), names[k]));
      columns[k].push_back(row[at].empty() ? std::numeric_limits<double>::quiet_NaN() : std::stod(row[at]));
    }
  }
  return columns;
}

}  // namespace voile::cli

#include "history_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>

#include "voile/errors.hpp"

namespace voile::cli {

Columns read_history(const std::filesystem::path& file, const std::vector<std::string>& names) {
  std::ifstream in(file);
  std::string line, cell;
  std::vector<std::string> head;
  std::getline(in, line);
  for (std::istringstream cells(line); std::getline(cells, cell, ',');) head.push_back(cell);
  Columns columns(names.size());
  while (std::getline(in, line)) {
    std::vector<std::string> row;
    for (std::istringstream cells(line); std::getline(cells, cell, ',');) row.push_back(cell);
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto at = static_cast<std::size_t>(std::find(head.begin(), head.end(), names[k]) - head.begin());
      if (at >= row.size()) throw InternalError(fmt::format("{}: there is no column {}", file.string(), names[k]));
      columns[k].push_back(row[at].empty() ? std::numeric_limits<double>::quiet_NaN() : std::stod(row[at]));
    }
  }
  return columns;
}

}  // namespace voile::cli

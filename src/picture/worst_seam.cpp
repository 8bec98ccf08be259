#include "worst_seam.hpp"

#include <fmt/format.h>

#include <charconv>
#include <sstream>
#include <vector>

#include "base/plain_file.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

/// Names of seams hold no commas: csv_name() of base/text.hpp has replaced them.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

}  // namespace

std::optional<WorstSeam> worst_seam(const std::filesystem::path& seams_csv) {
  const std::optional<std::string> text = text_of_file(seams_csv);
  if (!text) return std::nullopt;
  std::istringstream in(*text);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> head = cells_of(line);
  std::size_t gap_at = 0;
  while (gap_at < head.size() && head[gap_at] != "gap") ++gap_at;
  std::optional<WorstSeam> worst;
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = cells_of(line);
    double gap = 0.0;
    const bool good =
        gap_at < cells.size() &&
        std::from_chars(cells[gap_at].data(), cells[gap_at].data() + cells[gap_at].size(), gap).ec == std::errc();
    if (!good)
      throw UserError(fmt::format("{}: this is no table of seams as a stage that sews writes it; run the stage again",
                                  seams_csv.string()));
    if (!worst || gap > worst->gap) worst = WorstSeam{cells.front(), gap};
  }
  return worst;
}

}  // namespace voile::picture

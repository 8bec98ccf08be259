#include "worst_seam.hpp"

#include <fmt/format.h>

#include <charconv>
#include <sstream>
#include <vector>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

std::optional<WorstSeam> worst_seam(const std::filesystem::path& seams_csv) {
  const std::optional<std::string> text = text_of_file(seams_csv);
  if (!text) return std::nullopt;
  std::istringstream in(*text);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> head = csv_cells(line);
  std::size_t gap_at = 0;
  while (gap_at < head.size() && head[gap_at] != "gap") ++gap_at;
  std::optional<WorstSeam> worst;
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = csv_cells(line);
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

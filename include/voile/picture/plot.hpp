// Curves of columns of tables, as SVG or PNG.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "voile/picture/image.hpp"

namespace voile::picture {

/// A CSV file with a header line; lines before it that start with # are comments. Values that do not exist are NaN, and half a
/// line at the end is left away.
struct Table {
  std::filesystem::path file;
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  /// Throws UserError with the nearest name if there is no such column.
  [[nodiscard]] const std::vector<double>& column(const std::string& name) const;
  [[nodiscard]] bool has(const std::string& name) const;
};

/// `place`: a file, or a folder with history.csv in it. Throws UserError if it is not there or holds no table.
[[nodiscard]] Table read_table(const std::filesystem::path& place);

struct Curve {
  std::string label;
  std::vector<double> x, y;  ///< NaN: a gap
  bool points = false;       ///< marks instead of a line
  std::size_t colour = 0;    ///< number of the colour: curves that belong together share it
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<Curve> curves;
  int width = 960, height = 640;  ///< [pixels]
};

/// The ending of `file`, .svg or .png, says how. Throws UserError if there is nothing to draw, the ending is another or the
/// file cannot be written.
void write_plot(const std::filesystem::path& file, const Plot& plot);

}  // namespace voile::picture

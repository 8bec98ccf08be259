// Curves of columns of tables, as SVG or PNG.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "image.hpp"

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

enum class Stroke { line, dashed, points };

struct Curve {
  std::string label;         ///< empty: not in the legend
  std::vector<double> x, y;  ///< NaN, or not positive where the scale is logarithmic: a gap
  Stroke stroke = Stroke::line;
  std::size_t colour = 0;  ///< number of the colour: curves that belong together share it
};

/// Beside the axes at the right, in a corner of them, or nowhere.
enum class Legend { beside, top_left, top_right, bottom_left, bottom_right, none };

struct AxisOptions {
  std::string label;
  bool logarithmic = false;
  std::optional<std::pair<double, double>> range;  ///< else that of the curves, with a margin
};

struct Plot {
  std::string title;
  AxisOptions x, y;
  bool equal = false;  ///< a unit across is as long as one upwards
  Legend legend = Legend::beside;
  std::vector<Curve> curves;
  int width = 960, height = 640;  ///< [pixels]
};

/// The ending of `file`, .svg or .png, says how. Throws UserError if there is nothing to draw, the ending is another or the
/// file cannot be written.
void write_plot(const std::filesystem::path& file, const Plot& plot);

}  // namespace voile::picture

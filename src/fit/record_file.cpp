#include "record_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::fit {

namespace {

constexpr std::size_t least_rows = 3, most_rows = 100000;
constexpr double gap = 0.05;  ///< of the range that may stay open, or that noise may go back
/// A width below this fraction of the range of the force is none.
constexpr double least_width = 1e-4;
constexpr double gap_of_width = 1.2;  ///< a first bend begins in the middle of the loop

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  const char separator = line.find(';') != std::string::npos    ? ';'
                         : line.find('\t') != std::string::npos ? '\t'
                         : line.find(',') != std::string::npos  ? ','
                                                                : ' ';
  for (const char c : line) {
    if (c != separator) {
      const bool blank = c == ' ' || c == '\r' || c == '\t';
      if (!blank || !cells.back().empty()) cells.back() += c;  // one between digits stays: it is no number then
    } else if (separator != ' ' || !cells.back().empty()) {
      cells.emplace_back();
    }
  }
  for (std::string& cell : cells) cell.erase(cell.find_last_not_of(" \r\t") + 1);
  while (cells.size() > 1 && cells.back().empty()) cells.pop_back();
  return cells;
}

bool number_of(const std::string& cell, double& x) {
  const char* begin = cell.data() + (cell.starts_with('+') ? 1 : 0);
  const auto [end, problem] = std::from_chars(begin, cell.data() + cell.size(), x);
  return problem == std::errc() && end == cell.data() + cell.size() && std::isfinite(x);
}

struct Range {
  double x = 0.0, force = 0.0;
};
Range range_of(const std::vector<RecordPoint>& points) {
  const auto [x0, x1] = std::minmax_element(points.begin(), points.end(), [](auto& a, auto& b) { return a.x < b.x; });
  const auto [f0, f1] =
      std::minmax_element(points.begin(), points.end(), [](auto& a, auto& b) { return a.force < b.force; });
  return {x1->x - x0->x, f1->force - f0->force};
}

}  // namespace

std::vector<RecordPoint> read_rows(const std::string& file, const RecordPoint& scale) {
  const std::optional<std::string> text = text_of_file(file);
  if (!text) throw UserError(fmt::format("{}: there is no such file", file));
  std::istringstream in(*text);
  std::vector<RecordPoint> rows;
  std::string line;
  bool first = true;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line.starts_with('#')) continue;
    const std::vector<std::string> cells = cells_of(line);
    double x = 0.0, force = 0.0;
    const bool good = cells.size() == 2 && number_of(cells[0], x) && number_of(cells[1], force);
    if (!good && !first)
      throw UserError(
          fmt::format("{}:{}: '{}': two numbers are needed, with points as decimal marks, separated by a "
                      "comma, a semicolon or blanks",
                      file, number, printable(line.substr(0, 60))));
    first = false;
    if (good) rows.push_back({x * scale.x, force * scale.force});
    if (rows.size() > most_rows) throw UserError(fmt::format("{}: more than {} rows; thin them out", file, most_rows));
  }
  if (rows.size() < least_rows)
    throw UserError(fmt::format("{}: {} rows are too few; {} are needed", file, rows.size(), least_rows));
  return rows;
}

double require_loop(const std::vector<RecordPoint>& loop, const std::string& file) {
  const Range range = range_of(loop);
  if (!(range.x > 0.0 && range.force > 0.0)) throw UserError(fmt::format("{}: a column does not change", file));
  double area = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const RecordPoint &a = loop[i], &b = loop[(i + 1) % loop.size()];
    area += 0.5 * (a.force + b.force) * (b.x - a.x);
  }
  const double width = std::abs(area) / range.x, open = std::abs(loop.back().x - loop.front().x),
               open_force = std::abs(loop.back().force - loop.front().force);
  if (open > gap * range.x)
    throw UserError(
        fmt::format("{}: the loop is not closed: it ends {:.0f} % of its range from where it begins; give "
                    "the way out and back",
                    file, 100.0 * open / range.x));
  if (open_force > std::max(gap_of_width * width, gap * range.force))
    throw UserError(
        fmt::format("{}: the loop is not closed: its last force is {:.0f} % of the range from its first; "
                    "give one whole loop, without drift",
                    file, 100.0 * open_force / range.force));
  if (width < least_width * range.force)
    throw UserError(
        fmt::format("{}: the loop has no width: out and back are one line, without friction. Give its slope instead, "
                    "as bending_rigidity or membrane_stiffness.shear",
                    file));
  if (area < 0.0)
    throw UserError(
        fmt::format("{}: the loop turns the wrong way: it would give energy. The rows stand in reverse "
                    "order, or one column has the wrong sign",
                    file));
  return width;
}

void require_curve(const std::vector<RecordPoint>& curve, const std::string& file) {
  const Range range = range_of(curve);
  double furthest = curve.front().x;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if (curve[i].x < furthest - gap * range.x)
      throw UserError(
          fmt::format("{}: the curve turns back at row {}; give the way out only, and of shear a loop as "
                      "shear_loop",
                      file, i + 1));
    furthest = std::max(furthest, curve[i].x);
  }
  if (curve.front().x < -gap * range.x || !(furthest > 0.0) || !(curve.back().force > 0.0))
    throw UserError(fmt::format("{}: the curve has to begin at zero and to end with a positive force", file));
}

}  // namespace voile::fit

#include "voile/picture/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

#include "canvas.hpp"
#include "voile/base/error.hpp"
#include "voile/base/text.hpp"
#include "voile/picture/colour_map.hpp"

namespace voile::picture {

namespace fs = std::filesystem;

namespace {

constexpr std::array<Bytes3, 6> colours{
    {{31, 95, 139}, {200, 85, 61}, {63, 125, 78}, {138, 90, 156}, {184, 134, 11}, {68, 68, 68}}};
const Bytes3 ink{40, 44, 50}, grid{228, 230, 233}, frame{120, 124, 130};
constexpr double letters = 19.0;

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> row;
  std::string cell;
  for (std::istringstream in(line + ","); std::getline(in, cell, ',');) {
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\r')) cell.pop_back();
    while (!cell.empty() && cell.front() == ' ') cell.erase(0, 1);
    row.push_back(cell);
  }
  return row;
}

struct Axis {
  double low = std::numeric_limits<double>::infinity(), high = -low, begin = 0.0, end = 1.0;
  void add(double x) {
    if (!std::isfinite(x)) return;
    low = std::min(low, x);
    high = std::max(high, x);
  }
  /// A margin, but not beyond a zero that is near.
  void widen() {
    if (low == high) {
      low -= 0.5 * std::max(std::abs(low), 1e-12);
      high += 0.5 * std::max(std::abs(high), 1e-12);
    }
    const double width = high - low;
    if (low > 0.0 && low < 0.3 * width) low = 0.0;
    if (high < 0.0 && high > -0.3 * width) high = 0.0;
    if (low != 0.0) low -= 0.04 * width;
    if (high != 0.0) high += 0.04 * width;
  }
  [[nodiscard]] double place(double x) const { return begin + (end - begin) * (x - low) / (high - low); }
};

void draw_axes(Canvas& canvas, const Plot& plot, const Axis& x, const Axis& y) {
  for (const auto& [value, text] : ticks(x.low, x.high, 7)) {
    canvas.line({{x.place(value), y.begin}, {x.place(value), y.end}}, grid, 1.0);
    canvas.text({x.place(value), y.begin + 1.25 * letters}, text, 0.9 * letters, ink, Align::centre);
  }
  for (const auto& [value, text] : ticks(y.low, y.high, 6)) {
    canvas.line({{x.begin, y.place(value)}, {x.end, y.place(value)}}, grid, 1.0);
    canvas.text({x.begin - 0.5 * letters, y.place(value) + 0.3 * letters}, text, 0.9 * letters, ink, Align::right);
  }
  canvas.line({{x.begin, y.end}, {x.begin, y.begin}, {x.end, y.begin}}, frame, 1.3);
  canvas.text({x.end, y.begin + 2.7 * letters}, plot.x_label, letters, ink, Align::right);
  // Beside the axis' end, where it can be read without turning the head.
  canvas.text({x.begin, y.end - 0.7 * letters}, plot.y_label, letters, ink, Align::left);
  if (!plot.title.empty())
    canvas.text({0.5 * plot.width, 1.5 * letters}, plot.title, 1.15 * letters, ink, Align::centre);
}

void draw_curve(Canvas& canvas, const Curve& c, const Axis& x, const Axis& y) {
  const Bytes3& colour = colours[c.colour % colours.size()];
  std::vector<Vec2> points;
  for (std::size_t i = 0; i <= c.x.size(); ++i) {
    const bool there = i < c.x.size() && std::isfinite(c.x[i]) && std::isfinite(c.y[i]);
    if (there) points.emplace_back(x.place(c.x[i]), y.place(c.y[i]));
    if (there || points.empty()) continue;
    if (c.points || points.size() == 1)
      for (const Vec2& p : points) canvas.mark(p, colour, 4.5);
    else
      canvas.line(points, colour, 2.2);
    points.clear();
  }
}

void draw_legend(Canvas& canvas, const Plot& plot, double left, double top) {
  for (const Curve& c : plot.curves) {
    const Bytes3& colour = colours[c.colour % colours.size()];
    if (c.points)
      canvas.mark({left + 14.0, top - 0.3 * letters}, colour, 4.5);
    else
      canvas.line({{left, top - 0.3 * letters}, {left + 28.0, top - 0.3 * letters}}, colour, 2.2);
    canvas.text({left + 38.0, top}, c.label, 0.9 * letters, ink, Align::left);
    top += 1.25 * letters;
  }
}

}  // namespace

bool Table::has(const std::string& name) const {
  return std::find(names.begin(), names.end(), name) != names.end();
}

const std::vector<double>& Table::column(const std::string& name) const {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end())
    throw UserError(fmt::format("{}: there is no column '{}':{}", file.string(), name, suggestion(name, names)));
  return columns[static_cast<std::size_t>(at - names.begin())];
}

Table read_table(const fs::path& place) {
  std::error_code ignored;
  Table table;
  table.file = fs::is_directory(place, ignored) ? place / "history.csv" : place;
  std::ifstream in(table.file);
  if (!in)
    throw UserError(
        fmt::format("{}: there is no such table; give the output folder of a run, or a CSV file", table.file.string()));
  for (std::string line; std::getline(in, line);) {
    if (line.find('\0') != std::string::npos)
      throw UserError(fmt::format("{}: this is no CSV file: it is not text", table.file.string()));
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> row = cells(line);
    if (table.names.empty()) {
      table.names = row;
      table.columns.resize(row.size());
    } else if (row.size() == table.names.size()) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        char* end = nullptr;
        const double x = std::strtod(row[i].c_str(), &end);
        table.columns[i].push_back(row[i].empty() || *end != '\0' ? std::numeric_limits<double>::quiet_NaN() : x);
      }
    }
  }
  if (table.names.empty()) throw UserError(fmt::format("{}: the table is empty", table.file.string()));
  return table;
}

void write_plot(const fs::path& file, const Plot& plot) {
  const std::string ending = file.extension().string();
  if (ending != ".svg" && ending != ".png")
    throw UserError(fmt::format("--output {}: the name must end in .svg or .png", file.string()));
  Axis x, y;
  for (const Curve& c : plot.curves)
    for (std::size_t i = 0; i < c.x.size(); ++i)
      if (std::isfinite(c.x[i]) && std::isfinite(c.y[i])) {
        x.add(c.x[i]);
        y.add(c.y[i]);
      }
  if (!(x.low <= x.high))
    throw UserError(fmt::format("{}: there is nothing to draw: no row has numbers in both columns", file.string()));
  x.widen();
  y.widen();
  const std::unique_ptr<Canvas> canvas =
      ending == ".svg" ? svg_canvas(plot.width, plot.height) : pixel_canvas(plot.width, plot.height);
  double label = 0.0, legend = 0.0;
  for (const auto& [value, text] : ticks(y.low, y.high, 6)) label = std::max(label, text_width(text, 0.9 * letters));
  for (const Curve& c : plot.curves) legend = std::max(legend, text_width(c.label, 0.9 * letters) + 38.0);
  x.begin = label + 1.6 * letters;
  x.end = plot.width - 1.5 * letters - (plot.curves.size() > 1 ? legend + letters : 0.0);
  y.begin = plot.height - 3.4 * letters;
  y.end = (plot.title.empty() ? 2.2 : 4.0) * letters;
  draw_axes(*canvas, plot, x, y);
  for (const Curve& c : plot.curves) draw_curve(*canvas, c, x, y);
  if (plot.curves.size() > 1) draw_legend(*canvas, plot, x.end + letters, y.end + letters);
  canvas->write(file);
}

}  // namespace voile::picture

#include "voile/pattern/pattern.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "readers.hpp"
#include "voile/base/child_process.hpp"
#include "voile/base/error.hpp"
#include "voile/base/text.hpp"
#include "voile/pattern/outline.hpp"

namespace voile::pattern {

namespace {

/// Bounds of the extent of a piece [m]: beyond them its unit is wrong.
constexpr double smallest_piece = 0.005, largest_piece = 20.0;

std::string where(const Pattern& pattern, const Piece& piece) {
  return fmt::format("{}: piece '{}'", pattern.file.string(), piece.name);
}

void check_size(const Pattern& pattern, const Piece& piece) {
  const Extent e = extent_of(piece);
  const Vec2 size = e.high - e.low;
  if (size.allFinite() && size.maxCoeff() >= smallest_piece && size.maxCoeff() <= largest_piece) return;
  throw UserError(
      fmt::format("{}: it would be {:.4g} m x {:.4g} m, so the length of a unit must be wrong; give the key unit of "
                  "[[panel]]: 0.001 if "
                  "the file is in millimetres, 0.01 for centimetres, 0.0254 for inches",
                  where(pattern, piece), size[0], size[1]));
}

void check_names(const Pattern& pattern, const std::vector<std::string>& wanted) {
  std::vector<std::string> names;
  for (const Piece& p : pattern.pieces) {
    if (std::find(names.begin(), names.end(), p.name) != names.end())
      throw UserError(fmt::format("{}: another piece has this name too; rename one of them", where(pattern, p)));
    names.push_back(p.name);
  }
  for (const std::string& name : wanted)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw UserError(fmt::format("{}: there is no piece '{}'; those found: {}", pattern.file.string(), name,
                                  names.empty() ? "none" : join(names, ", ")));
}

void check_outline(const Pattern& pattern, const Piece& piece) {
  const std::string at = where(pattern, piece);
  if (piece.edges.size() < 2) throw UserError(fmt::format("{}: an outline has at least two edges", at));
  std::vector<Vec2> points;
  std::vector<std::size_t> edge_of;
  for (std::size_t k = 0; k < piece.edges.size(); ++k) {
    const Curve& c = piece.edges[k].curve;
    if (!(c.length() > 1e-6)) throw UserError(fmt::format("{}, edge {}: it has no length; remove it", at, k));
    const int parts = c.steps();
    for (int i = 0; i < parts; ++i) {
      points.push_back(c.at(static_cast<double>(i) / parts));
      edge_of.push_back(k);
    }
  }
  if (const auto crossing = find_crossing(points)) {
    const std::size_t a = edge_of[crossing->first], b = edge_of[crossing->second];
    const Vec2& x = crossing->place;
    throw UserError(
        a == b ? fmt::format("{}, edge {}: it crosses itself near ({:.4g}, {:.4g}) m; correct the curve", at, a, x[0],
                             x[1])
               : fmt::format("{}: edges {} and {} cross or touch near ({:.4g}, {:.4g}) m: an outline goes round once "
                             "without a figure of eight; correct the order or the place of its points",
                             at, a, b, x[0], x[1]));
  }
}

}  // namespace

double Piece::signed_area() const {
  double sum = 0.0;
  for (const Edge& e : edges) sum += e.curve.area();
  return sum;
}

std::string text_of(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) throw UserError(fmt::format("{}: there is no such file", file.string()));
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in.is_open() || std::filesystem::is_directory(file, ignored))
    throw UserError(fmt::format("{}: the file cannot be read; check its permissions", file.string()));
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw UserError(fmt::format("{}: the file is empty", file.string()));
  return text;
}

std::optional<std::size_t> number_below(const std::string& text, std::size_t end) {
  if (text.empty() || text.size() > 6 || !std::all_of(text.begin(), text.end(), ::isdigit)) return std::nullopt;
  const std::size_t k = std::stoul(text);
  return k < end ? std::optional(k) : std::nullopt;
}

namespace {

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

Pattern read_unguarded(const std::filesystem::path& file, const ReadOptions& options) {
  const std::string extension = lower_extension(file);
  Pattern pattern = extension == ".json"  ? read_garmentcode(file, options)
                    : extension == ".svg" ? read_svg(file, options)
                                          : read_dxf(file, options);
  check_names(pattern, options.pieces);
  if (!options.unfold.empty()) unfold_pieces(pattern, options.unfold);
  for (const Piece& piece : pattern.pieces) {
    check_size(pattern, piece);
    check_outline(pattern, piece);
  }
  return pattern;
}

}  // namespace

Pattern read_pattern(const std::filesystem::path& file, const ReadOptions& options) {
  if (const std::string extension = lower_extension(file);
      extension != ".json" && extension != ".svg" && extension != ".dxf")
    throw UserError(fmt::format("{}: unknown kind of pattern '{}'; give a GarmentCode .json, an .svg or a .dxf",
                                file.string(), extension));
  try_in_child(file.string(), [&] { (void)read_unguarded(file, options); });
  return read_unguarded(file, options);
}

}  // namespace voile::pattern

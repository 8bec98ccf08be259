#include "pattern.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "base/child_process.hpp"
#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "outline.hpp"
#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// Bounds of the extent of a piece [m]: beyond them its unit is wrong.
constexpr double smallest_piece = 0.005, largest_piece = 20.0;

std::vector<Vec3> flat(const std::vector<Vec2>& plane) {
  std::vector<Vec3> all;
  for (const Vec2& x : plane) all.emplace_back(x[0], x[1], 0.0);
  return all;
}

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

std::string loop_name(const Piece& piece, std::size_t edge) {
  const Piece::Loop loop = piece.loop_of(edge);
  return fmt::format("{} (edges {} to {})", piece.is_in_outline(edge) ? "the outline" : "the hole", loop.begin,
                     loop.end - 1);
}

/// Why two edges must not have a point in common, and what to do.
std::string crossing_text(const Piece& piece, std::size_t a, std::size_t b, const Vec2& x) {
  const std::string place = fmt::format("near ({:.4g}, {:.4g}) m", x[0], x[1]);
  if (a == b) return fmt::format(", edge {}: it crosses itself {}; correct the curve", a, place);
  if (piece.loop_of(a).begin == piece.loop_of(b).begin)
    return fmt::format(
        ": edges {} and {} cross or touch {}: {} goes round once without a figure of eight; correct the order "
        "or the place of its points",
        a, b, place, piece.is_in_outline(a) ? "an outline" : "a hole");
  return fmt::format(
      ": edges {} and {} cross or touch {}: {} and {} must be clear of each other; move the hole, make it smaller, or "
      "draw both as one",
      a, b, place, loop_name(piece, a), loop_name(piece, b));
}

void check_holes(const std::string& at, const Piece& piece, const Polygons& polygons) {
  const auto stray = find_stray(polygons, piece.outline());
  if (!stray) return;
  const std::vector<Piece::Loop> loops = piece.loops();
  const Piece::Loop& loop = loops[stray->loop];
  if (stray->hole)
    throw UserError(
        fmt::format("{}: the loop of edges {} to {} lies inside of {}, where there is no fabric; remove it, or make it "
                    "a piece of its own",
                    at, loop.begin, loop.end - 1, loop_name(piece, loops[*stray->hole].begin)));
  throw UserError(
      fmt::format("{}: the loop of edges {} to {} lies outside of the outline, so it is no hole; a piece has one "
                  "outline: draw others as pieces of their own, or move the hole inside",
                  at, loop.begin, loop.end - 1));
}

void check_loops(const Pattern& pattern, const Piece& piece) {
  const std::string at = where(pattern, piece);
  for (std::size_t k = 0; k < piece.edges.size(); ++k)
    if (!(piece.edges[k].curve.length() > 1e-6))
      throw UserError(fmt::format("{}, edge {}: it has no length; remove it", at, k));
  Polygons polygons;
  std::vector<std::size_t> edge_of;
  for (const Piece::Loop& loop : piece.loops()) {
    if (loop.end < loop.begin + 2)
      throw UserError(fmt::format("{}: {} has at least two edges", at,
                                  piece.loops().size() == 1 ? "an outline" : loop_name(piece, loop.begin)));
    std::vector<Vec2>& points = polygons.emplace_back();
    for (std::size_t k = loop.begin; k < loop.end; ++k) {
      const std::vector<Vec2> own = polygon_of({piece.edges[k].curve});
      points.insert(points.end(), own.begin(), own.end());
      edge_of.insert(edge_of.end(), own.size(), k);
    }
  }
  if (const auto crossing = find_crossing(polygons))
    throw UserError(at + crossing_text(piece, edge_of[crossing->first], edge_of[crossing->second], crossing->place));
  check_holes(at, piece, polygons);
}

}  // namespace

void check_piece(const Pattern& pattern, const Piece& piece) {
  check_size(pattern, piece);
  check_loops(pattern, piece);
}

BentShape::BentShape(const std::vector<Vec2>& plane, std::vector<Vec3> space, std::vector<mesh::Triangle> triangles)
    : plane_(flat(plane)), space_(std::move(space)), triangles_(std::move(triangles)), closest_(plane_, triangles_) {}

Vec3 BentShape::at(const Vec2& x) const {
  const Vec3 p(x[0], x[1], 0.0);
  const mesh::Triangle& t = triangles_[static_cast<std::size_t>(closest_.find(p))];
  const auto corner = [&](std::size_t i) { return static_cast<std::size_t>(t[i]); };
  const Vec3 w = geometry::nearest_weights(p, {plane_[corner(0)], plane_[corner(1)], plane_[corner(2)]});
  return w[0] * space_[corner(0)] + w[1] * space_[corner(1)] + w[2] * space_[corner(2)];
}

void Piece::add_loop(std::vector<Edge> loop) {
  if (!edges.empty()) further_loops.push_back(edges.size());
  edges.insert(edges.end(), std::make_move_iterator(loop.begin()), std::make_move_iterator(loop.end()));
}

std::vector<Piece::Loop> Piece::loops() const {
  std::vector<Loop> all{{0, edges.size()}};
  for (const std::size_t begin : further_loops) {
    all.back().end = begin;
    all.push_back({begin, edges.size()});
  }
  return all;
}

Piece::Loop Piece::loop_of(std::size_t edge) const {
  for (const Loop& loop : loops())
    if (edge < loop.end) return loop;
  throw InternalError(fmt::format("piece '{}' has no edge {}", name, edge));
}

std::size_t Piece::outline() const {
  const std::vector<Loop> all = loops();
  std::size_t largest = 0;
  for (std::size_t k = 1; k < all.size(); ++k)
    if (std::abs(signed_area(all[k])) > std::abs(signed_area(all[largest]))) largest = k;
  return largest;
}

bool Piece::is_in_outline(std::size_t edge) const {
  return loop_of(edge).begin == loops()[outline()].begin;
}

std::size_t Piece::next(std::size_t edge) const {
  const Loop loop = loop_of(edge);
  return edge + 1 < loop.end ? edge + 1 : loop.begin;
}

double Piece::signed_area(const Loop& loop) const {
  double sum = 0.0;
  for (std::size_t k = loop.begin; k < loop.end; ++k) sum += edges[k].curve.area();
  return sum;
}

double Piece::signed_area() const {
  double sum = 0.0, whole = 0.0;
  for (const Loop& loop : loops()) {
    const double own = signed_area(loop);
    sum += std::abs(own);
    if (std::abs(own) > std::abs(whole)) whole = own;
  }
  return std::copysign(2.0 * std::abs(whole) - sum, whole);
}

std::string text_of(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) throw UserError(fmt::format("{}: there is no such file", file.string()));
  std::ifstream in = open_input(file);
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
                    : extension == ".obj" ? read_obj(file, options)
                    : extension == ".geo" ? read_geo(file, options)
                                          : read_dxf(file, options);
  check_names(pattern, options.pieces);
  if (!options.unfold.empty()) {
    for (const Piece& piece : pattern.pieces)
      if (piece.bent)
        throw UserError(
            fmt::format("{}: unfold: it is bent in space, where its other half would have no place; remove the "
                        "key, or lay the piece flat in the file",
                        where(pattern, piece)));
    unfold_pieces(pattern, options.unfold);
  }
  for (const Piece& piece : pattern.pieces) check_piece(pattern, piece);
  return pattern;
}

}  // namespace

Pattern read_pattern(const std::filesystem::path& file, const ReadOptions& options) {
  if (const std::string extension = lower_extension(file);
      extension != ".json" && extension != ".svg" && extension != ".dxf" && extension != ".obj" && extension != ".geo")
    throw UserError(
        fmt::format("{}: unknown kind of pattern '{}'; give a GarmentCode .json, an .svg, a .dxf, a .geo or an .obj",
                    file.string(), extension));
  else if (options.texture_unit > 0.0 && extension != ".obj")
    throw UserError(fmt::format("{}: texture_unit: only an .obj has texture coordinates; give unit", file.string()));
  else if (!options.parameters.empty() && extension != ".geo")
    throw UserError(fmt::format("{}: parameters: only a .geo has some; remove the key", file.string()));
  else if (!options.nest_size.empty() && extension != ".dxf")
    throw UserError(fmt::format("{}: nest_size: only a .dxf has sizes; remove the key", file.string()));
  if (lower_extension(file) != ".geo")  // which is read by a process of its own
    try_in_child(file.string(), [&] { (void)read_unguarded(file, options); });
  return read_unguarded(file, options);
}

}  // namespace voile::pattern

// Pieces drawn as plane surfaces in a Gmsh script.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "formats/geo_outline.hpp"
#include "readers.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

constexpr double off_plane = 1e-9;  // of the extent

Vec2 in_plane(const Vec3& x) {
  return {x[0], x[1]};
}

/// Cubics with the points and derivatives of the curve.
Curve curve_of(const formats::GeoCurve& c, double unit) {
  const auto at = [&](std::size_t k) { return Vec2(unit * in_plane(c.points[k])); };
  if (c.points.size() == 2) return Curve::bezier({at(0), at(1)});
  std::vector<Curve> parts;
  for (std::size_t k = 0; k + 1 < c.points.size(); ++k) {
    const Vec2 a = at(k), b = at(k + 1);
    parts.push_back(Curve::bezier(
        {a, a + unit / 3.0 * in_plane(c.derivatives[k]), b - unit / 3.0 * in_plane(c.derivatives[k + 1]), b}));
  }
  return Curve::chain(std::move(parts));
}

void check_plane(const std::string& file, const formats::GeoFace& face) {
  const double height = face.loops.front().front().points.front()[2];
  double extent = 0.0, off = 0.0;
  for (const auto& loop : face.loops)
    for (const formats::GeoCurve& c : loop)
      for (const Vec3& x : c.points) {
        extent = std::max(extent, (x - face.loops.front().front().points.front()).norm());
        off = std::max(off, std::abs(x[2] - height));
      }
  if (off > off_plane * extent)
    throw UserError(
        fmt::format("{}: piece '{}' does not lie in a plane of constant z (off by {:.3g}); draw pieces flat, "
                    "and place them by the keys of [[panel]]",
                    file, face.name, off));
}

}  // namespace

Pattern read_geo(const std::filesystem::path& file, const ReadOptions& options) {
  Pattern pattern;
  pattern.file = file;
  const double unit = options.unit > 0.0 ? options.unit : 1.0;
  std::vector<std::string> seen;
  for (const formats::GeoFace& face :
       formats::read_geo_faces(file.string(), options.parameters, options.allow_system_call)) {
    seen.push_back(face.name);
    if (!options.pieces.empty() &&
        std::find(options.pieces.begin(), options.pieces.end(), face.name) == options.pieces.end())
      continue;
    if (face.loops.empty()) throw UserError(fmt::format("{}: piece '{}' has no outline", file.string(), face.name));
    check_plane(file.string(), face);
    Piece& piece = pattern.pieces.emplace_back();
    piece.name = face.name;
    bool named = false;
    for (const std::vector<formats::GeoCurve>& loop : face.loops) {
      std::vector<Edge> edges;
      for (const formats::GeoCurve& c : loop) {
        edges.push_back({curve_of(c, unit), c.name});
        piece.point_names.push_back(c.start_name);
        named = named || !c.start_name.empty();
      }
      piece.add_loop(std::move(edges));
    }
    if (!named) piece.point_names.clear();
  }
  for (const std::string& name : options.pieces)
    if (std::find(seen.begin(), seen.end(), name) == seen.end())
      throw UserError(
          fmt::format("{}: there is no piece '{}'; those found: {}", file.string(), name, join(seen, ", ")));
  return pattern;
}

}  // namespace voile::pattern

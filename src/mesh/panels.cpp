#include "panels.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "voile/errors.hpp"

namespace voile::mesh {

namespace {

/// Ratio of the areas of panels and positions beyond which the unit must be wrong: a factor of 5 in length.
constexpr double largest_ratio = 25.0;

UserError wrong(const std::string& source, const std::string& what) {
  return UserError(fmt::format("{}: [mesh] rest = \"texture\": {}", source, what));
}

/// Throws if there are such triangles; says of which one.
void require_none(const MeshData& data, const std::vector<Index>& triangles, const std::string& what,
                  const std::string& remedy) {
  if (triangles.empty()) return;
  const auto first = static_cast<std::size_t>(triangles.front());
  const std::size_t tag = first < data.triangle_tags.size() ? data.triangle_tags[first] : first + 1;
  const Vec3& x = data.positions[data.triangles[first][0]];
  throw wrong(data.source, fmt::format("{} of {} triangles {}, the first is {} at ({:.4g}, {:.4g}, {:.4g}); {}",
                                       triangles.size(), data.triangles.size(), what, tag, x[0], x[1], x[2], remedy));
}

}  // namespace

void take_rest_from_texture(MeshData& data, double unit) {
  if (data.texture.size() != data.triangles.size())
    throw wrong(data.source,
                "the file has no texture coordinates; give an OBJ file that has them (\"vt\"), or remove the key");
  std::vector<Index> missing, flat;
  double panels = 0.0, positions = 0.0;
  data.rest.resize(data.triangles.size());
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    std::array<Vec3, 3>& rest = data.rest[t];
    bool given = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2& uv = data.texture[t][i];
      given = given && uv.allFinite();
      rest[i] = unit * Vec3(uv[0], uv[1], 0.0);
    }
    const double area = triangle_area(rest[0], rest[1], rest[2]);
    const double longest =
        std::max({(rest[1] - rest[0]).norm(), (rest[2] - rest[1]).norm(), (rest[0] - rest[2]).norm()});
    if (!given)
      missing.push_back(static_cast<Index>(t));
    else if (!(area > 0.5e-10 * longest * longest))
      flat.push_back(static_cast<Index>(t));
    const Triangle& v = data.triangles[t];
    panels += area;
    positions += triangle_area(data.positions[v[0]], data.positions[v[1]], data.positions[v[2]]);
  }
  require_none(data, missing, "have no texture coordinates",
               "give every face its place in the panels (\"vt\"), or remove what is not fabric");
  require_none(data, flat, "have no area in their texture coordinates", "correct the panels there");
  const double ratio = panels / positions;
  if (!(ratio <= largest_ratio && ratio >= 1.0 / largest_ratio))
    throw wrong(
        data.source,
        fmt::format("the panels have {:.3g} times the area of the shape that the vertices form ({:.4g} and {:.4g} "
                    "m^2); texture_unit = {:g} is wrong, with {:.3g} both would be alike, or correct `scale`",
                    ratio, panels, positions, unit, unit / std::sqrt(ratio)));
}

void check_panels(const SurfaceMesh& mesh) {
  std::vector<Index> mirrored;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    if (mesh.rest_normal(t)[2] < 0.0) mirrored.push_back(t);
  require_none(mesh.data(), mirrored,
               "are mirrored in their panels: their texture coordinates turn the other way round",
               static_cast<Index>(mirrored.size()) == mesh.triangle_count()
                   ? "turn the normals of the mesh to the side from which the panels are seen, or mirror all panels"
                   : "mirror those panels in the pattern");
}

std::vector<std::string> seam_notes(const SurfaceMesh& mesh) {
  if (!mesh.has_charts()) return {};
  Index seams = 0;
  double longest = 1.0;
  double panels = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    panels += mesh.area(t);
    for (int s = 0; s < 3; ++s) {
      if (mesh.neighbour(t, s) < t) continue;
      const Join join = mesh.chart_join(t, s);
      if (join.same_chart) continue;
      ++seams;
      longest = std::max({longest, join.stretch, 1.0 / join.stretch});
    }
  }
  std::string text = fmt::format("the shape without stress is {:.4g} m^2 of flat panels", panels);
  if (seams > 0)
    text += fmt::format("; {} edges are seams, whose two sides differ in length by at most {:.2g} %", seams,
                        100.0 * (longest - 1.0));
  return {text};
}

}  // namespace voile::mesh

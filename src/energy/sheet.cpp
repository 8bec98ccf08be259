#include "sheet.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <utility>

#include "voile/errors.hpp"

namespace voile::energy {

std::vector<int> assign_materials(const mesh::SurfaceMesh& mesh, const std::vector<Material>& materials) {
  std::vector<int> of(static_cast<std::size_t>(mesh.triangle_count()), -1);
  int everywhere = -1;
  for (int m = 0; m < static_cast<int>(materials.size()); ++m) {
    if (materials[m].groups.empty()) {
      if (everywhere >= 0) throw UserError("[[material]]: two materials name no groups; only one can cover the rest");
      everywhere = m;
    }
    for (const std::string& name : materials[m].groups)
      for (Index t : mesh.group(name, 2).triangles) {
        if (of[t] >= 0 && of[t] != m)
          throw UserError(
              fmt::format("[[material]] groups '{}': triangle {} already has another material; let groups "
                          "not overlap",
                          name, mesh.data().triangle_tags[t]));
        of[t] = m;
      }
  }
  for (std::size_t t = 0; t < of.size(); ++t) {
    if (of[t] < 0) of[t] = everywhere;
    if (of[t] < 0)
      throw UserError(
          fmt::format("[[material]]: triangle {} of {} has no material; name its group, or leave out "
                      "`groups` in one [[material]] to cover the rest",
                      mesh.data().triangle_tags[t], mesh.source()));
  }
  return of;
}

namespace {

/// Sine of the angle between a direction and the normal of a triangle below which its projection says nothing.
constexpr double smallest_projection = 0.05;

/// Direction in the chart of a direction in texture coordinates; zero where those of the triangle span no area.
Vec3 from_texture(const mesh::SurfaceMesh& mesh, Index t, const Vec2& wanted) {
  const std::array<Vec2, 3>& uv = mesh.data().texture[static_cast<std::size_t>(t)];
  const Vec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
  const double area = a[0] * b[1] - a[1] * b[0];
  if (!(std::abs(area) > 1e-12 * (a.squaredNorm() + b.squaredNorm()))) return Vec3::Zero();
  const double first = (wanted[0] * b[1] - wanted[1] * b[0]) / area,
               second = (a[0] * wanted[1] - a[1] * wanted[0]) / area;
  const Vec3 corner = mesh.rest_corner(t, 0);
  return (first * (mesh.rest_corner(t, 1) - corner) + second * (mesh.rest_corner(t, 2) - corner)).normalized();
}

/// The axis of neighbour n turned about the common side into the plane of t.
Vec3 unfolded_axis(const mesh::SurfaceMesh& mesh, Index t, int side, Index n, const Vec3& axis) {
  const Vec3 along = (mesh.rest_corner(t, (side + 2) % 3) - mesh.rest_corner(t, (side + 1) % 3)).normalized();
  const Mat3 turn = mesh.chart_join(t, side).turn;
  const Vec3 carried = turn * axis, normal = turn * mesh.rest_normal(n);
  return carried.dot(along) * along + carried.dot(normal.cross(along)) * mesh.rest_normal(t).cross(along);
}

/// Axes of the triangles that wait, ring by ring from those that have one. Returns those that nobody reaches.
std::vector<Index> continue_axes(const mesh::SurfaceMesh& mesh, const std::vector<int>& material_of,
                                 std::vector<Index> waiting, std::vector<Vec3>& axes) {
  while (!waiting.empty()) {
    std::vector<std::pair<Index, Vec3>> found;
    std::vector<Index> left;
    for (const Index t : waiting) {
      Vec3 sum = Vec3::Zero(), first = Vec3::Zero();
      for (int s = 0; s < 3; ++s) {
        const Index n = mesh.neighbour(t, s);
        if (n == no_index || material_of[n] != material_of[t] || axes[n] == Vec3::Zero()) continue;
        const Vec3 axis = unfolded_axis(mesh, t, s, n, axes[n]);
        if (first == Vec3::Zero()) first = axis;
        sum += axis;
      }
      if (first == Vec3::Zero())
        left.push_back(t);
      else
        found.emplace_back(t, (sum.norm() > 0.1 ? sum : first).normalized());
    }
    if (found.empty()) return left;
    for (const auto& [t, axis] : found) axes[t] = axis;
    waiting.swap(left);
  }
  return {};
}

/// What the file or the material itself says of the axis of triangle t; zero where that is nothing.
Vec3 own_axis(const mesh::SurfaceMesh& mesh, Index t, const Material& m) {
  if (m.texture_direction) return from_texture(mesh, t, *m.texture_direction);
  const Vec3 normal = mesh.rest_normal(t), wanted = m.direction->normalized();
  const Vec3 projected = wanted - wanted.dot(normal) * normal;
  return projected.norm() < smallest_projection ? Vec3::Zero() : projected.normalized();
}

}  // namespace

MaterialAxes material_axes(const mesh::SurfaceMesh& mesh, const std::vector<Material>& materials,
                           const std::vector<int>& material_of) {
  MaterialAxes result;
  std::vector<Vec3> axes(material_of.size(), Vec3::Zero());
  std::vector<Index> waiting;
  bool textured = false;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const Material& m = materials[material_of[t]];
    if (!m.direction && !m.texture_direction) continue;
    if (m.texture_direction && mesh.data().texture.empty())
      throw UserError(
          fmt::format("[[material]] texture_direction: {} has no texture coordinates; give an OBJ file that "
                      "has them ('vt'), or 'direction'",
                      mesh.source()));
    textured = textured || m.texture_direction;
    axes[t] = own_axis(mesh, t, m);
    if (axes[t] == Vec3::Zero()) waiting.push_back(t);
  }
  if (waiting.empty() && !textured) return result;
  const std::vector<Index> lost = continue_axes(mesh, material_of, waiting, axes);
  if (!lost.empty())
    throw UserError(
        fmt::format("{}: the material direction does not reach triangle {} and {} other(s) that no triangle with a "
                    "direction is "
                    "next to: it is normal to them, or they have no texture coordinates; give them a [[material]] of "
                    "their own group "
                    "with a 'direction' in their surface",
                    mesh.source(), mesh.data().triangle_tags[lost.front()], lost.size() - 1));
  result.continued = static_cast<Index>(waiting.size());
  // Where the direction itself serves, its projection stays to the last digit what it was.
  std::vector<char> continued(axes.size(), 0);
  for (const Index t : waiting) continued[t] = 1;
  for (std::size_t t = 0; t < axes.size(); ++t)
    if (!continued[t] && !materials[material_of[t]].texture_direction) axes[t].setZero();
  result.of = std::move(axes);
  return result;
}

}  // namespace voile::energy

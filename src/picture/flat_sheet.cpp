#include "flat_sheet.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "voile/errors.hpp"

namespace voile::picture {

namespace {

constexpr double same_plane = 1e-6;        // 1 - cosine of the angle between neighbours
constexpr double least_projection = 0.05;  // sine of the angle of a direction with the normal
constexpr double same_shape = 0.02;        // by which texture may be stretched against the sheet

using FlatCorners = std::array<Vec2f, 3>;

Vec3 double_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).cross(c - a);
}

std::array<Vec3, 3> rest_corners(const mesh::MeshData& mesh, std::size_t t) {
  if (!mesh.rest.empty()) return mesh.rest[t];
  const mesh::Triangle& v = mesh.triangles[t];
  return {mesh.positions[static_cast<std::size_t>(v[0])], mesh.positions[static_cast<std::size_t>(v[1])],
          mesh.positions[static_cast<std::size_t>(v[2])]};
}

/// Length of 1 in texture coordinates: what makes the areas alike. 0: they have none.
double texture_unit(const mesh::MeshData& mesh) {
  double flat = 0.0, rest = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.texture[t];
    const auto [x, y, z] = rest_corners(mesh, t);
    const double twice = std::abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]);
    if (!std::isfinite(twice)) return 0.0;
    flat += twice;
    rest += double_area(x, y, z).norm();
  }
  return flat > 0.0 ? std::sqrt(rest / flat) : 0.0;
}

/// Coordinates across and along `warp` of places in a plane.
Vec2f turned(const Vec2& at, const Vec2& warp) {
  return {static_cast<float>(at[0] * warp[1] - at[1] * warp[0]), static_cast<float>(at.dot(warp))};
}

Vec2 unit_of(const Vec2& direction) {
  return direction.norm() > 0.0 ? Vec2(direction.normalized()) : Vec2(0.0, 1.0);
}

/// In the plane of a triangle, whose normal is n.
FlatCorners in_plane(const std::array<Vec3, 3>& x, const Vec3& n, const SheetMaterial& m) {
  const std::optional<Vec3>& wanted = m.direction;
  Vec3 warp = Vec3::Zero();
  for (const Vec3& d : {wanted.value_or(Vec3::UnitX()), Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY())})
    if (warp.isZero(0.0) && (d - d.dot(n) * n).norm() > least_projection * d.norm()) warp = d - d.dot(n) * n;
  warp = Eigen::AngleAxisd(m.warp_angle, n) * warp.normalized();
  const Vec3 across = warp.cross(n);
  FlatCorners flat;
  for (std::size_t i = 0; i < 3; ++i) flat[i] = Vec2(x[i].dot(across), x[i].dot(warp)).cast<float>();
  return flat;
}

/// Direction in texture coordinates of one at rest, projected into triangle t; zero where they span no area.
Vec2 in_texture(const mesh::MeshData& mesh, std::size_t t, const Vec3& wanted) {
  const auto [x, y, z] = rest_corners(mesh, t);
  const Vec3 e = y - x, f = z - x;
  const Vec2 a = mesh.texture[t][1] - mesh.texture[t][0], b = mesh.texture[t][2] - mesh.texture[t][0];
  const double ee = e.dot(e), ef = e.dot(f), ff = f.dot(f), area2 = ee * ff - ef * ef;
  if (!(area2 > 0.0)) return Vec2::Zero();
  const double we = wanted.dot(e), wf = wanted.dot(f);
  return ((we * ff - wf * ef) * a + (wf * ee - we * ef) * b) / area2;
}

/// Warp of each material in texture coordinates: one for all its triangles, so that patterns run on from one to the next.
std::vector<Vec2> texture_warps(const mesh::MeshData& mesh, const std::vector<SheetMaterial>& materials,
                                const std::vector<std::size_t>& of) {
  std::vector<Vec2> warps(std::max<std::size_t>(materials.size(), 1), Vec2::Zero());
  std::vector<double> sense(warps.size(), 0.0);
  for (std::size_t t = 0; t < of.size() && !materials.empty(); ++t) {
    const SheetMaterial& m = materials[of[t]];
    const auto [a, b, c] = mesh.texture[t];
    sense[of[t]] += (b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0];
    if (!m.direction || m.texture_direction) continue;
    const auto [x, y, z] = rest_corners(mesh, t);
    warps[of[t]] += double_area(x, y, z).norm() * in_texture(mesh, t, m.direction->normalized());
  }
  for (std::size_t m = 0; m < materials.size(); ++m)
    if (materials[m].texture_direction) warps[m] = *materials[m].texture_direction;
  for (Vec2& warp : warps) warp = unit_of(warp);
  for (std::size_t m = 0; m < materials.size(); ++m)  // a drawing that is mirrored turns the other way
    warps[m] =
        Eigen::Rotation2Dd(std::copysign(materials[m].warp_angle, sense[m] * materials[m].warp_angle)) * warps[m];
  return warps;
}

/// Largest ratio of a side to that of the texture, of unit length `unit`, less 1; either way.
double stretch_of_texture(const mesh::MeshData& mesh, double unit) {
  double most = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::array<Vec3, 3> x = rest_corners(mesh, t);
    for (std::size_t i = 0; i < 3; ++i) {
      const double length = (x[(i + 1) % 3] - x[i]).norm(),
                   flat = unit * (mesh.texture[t][(i + 1) % 3] - mesh.texture[t][i]).norm();
      most = std::max(most, std::max(length, flat) / std::max(std::min(length, flat), 1e-30) - 1.0);
    }
  }
  return most;
}

double unit_of_texture(const mesh::MeshData& mesh) {
  return mesh.texture.size() == mesh.triangles.size() ? texture_unit(mesh) : 0.0;
}

/// Normals of triangles [unit length], if all round each vertex are alike; else none.
std::vector<Vec3> plane_normals(const mesh::MeshData& mesh) {
  std::vector<Vec3> of_triangle, of_vertex(mesh.positions.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = rest_corners(mesh, t);
    const Vec3 n = double_area(a, b, c).normalized();
    for (const Index v : mesh.triangles[t]) {
      Vec3& first = of_vertex[static_cast<std::size_t>(v)];
      if (first.isZero(0.0)) first = n;
      if (!(first.dot(n) > 1.0 - same_plane)) return {};
    }
    of_triangle.push_back(n);
  }
  return of_triangle;
}

}  // namespace

std::vector<std::size_t> materials_of(const mesh::MeshData& mesh, const std::vector<SheetMaterial>& materials) {
  std::size_t everywhere = 0;
  for (std::size_t m = 0; m < materials.size(); ++m)
    if (materials[m].groups.empty()) everywhere = m;
  std::vector<std::size_t> of(mesh.triangles.size(), everywhere);
  for (std::size_t m = 0; m < materials.size(); ++m)
    for (const mesh::Group& g : mesh.groups)
      if (g.dimension == 2 &&
          std::find(materials[m].groups.begin(), materials[m].groups.end(), g.name) != materials[m].groups.end())
        for (const Index t : g.triangles) of[static_cast<std::size_t>(t)] = m;
  return of;
}

double uneven_texture(const mesh::MeshData& mesh) {
  const double unit = unit_of_texture(mesh);
  if (!(unit > 0.0) || (mesh.rest.empty() && !plane_normals(mesh).empty())) return 0.0;
  const double stretch = stretch_of_texture(mesh, unit);
  return stretch > same_shape ? stretch : 0.0;
}

std::vector<FlatCorners> flat_coordinates(const mesh::MeshData& mesh, const std::vector<SheetMaterial>& materials) {
  const std::vector<std::size_t> of = materials_of(mesh, materials);
  const double unit = unit_of_texture(mesh);
  const std::vector<Vec3> normals = mesh.rest.empty() ? plane_normals(mesh) : std::vector<Vec3>{};
  // A picture's texture, from 0 to 1 each way, is not the shape of the cloth.
  const bool is_drawn = unit > 0.0 && (normals.empty() || stretch_of_texture(mesh, unit) <= same_shape);
  std::vector<FlatCorners> flat;
  if (is_drawn) {
    const std::vector<Vec2> warps = texture_warps(mesh, materials, of);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      FlatCorners& corners = flat.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) corners[i] = turned(unit * mesh.texture[t][i], warps[of[t]]);
    }
    return flat;
  }
  if (normals.empty() && mesh.rest.empty() && !mesh.triangles.empty())
    throw UserError(
        "--cloth, --print: the sheet is curved at the start and has no texture coordinates for its threads; give an "
        "OBJ mesh with texture coordinates (vt), sew panels, or leave the option out");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    flat.push_back(in_plane(rest_corners(mesh, t), normals.empty() ? Vec3(Vec3::UnitZ()) : normals[t],
                            materials.empty() ? SheetMaterial{} : materials[of[t]]));
  return flat;
}

}  // namespace voile::picture

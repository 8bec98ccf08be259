#include "dimples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voile::record {

namespace {

bool is_pressed(const input::Case& c) {
  using Kind = system::Load::Kind;
  return std::any_of(c.loads.begin(), c.loads.end(), [](const system::Load& load) {
    return load.kind == Kind::pressure || load.kind == Kind::follower_pressure || load.kind == Kind::gas;
  });
}

/// Vertices of planes of symmetry.
std::vector<char> mirrored_vertices(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  std::vector<char> mirrored(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (const system::Support& s : c.supports)
    if (s.kind == system::Support::Kind::symmetry)
      for (const Index v : mesh.group(s.group).vertices) mirrored[static_cast<std::size_t>(v)] = 1;
  return mirrored;
}

}  // namespace

Dimple deepest_dimple(const mesh::SurfaceMesh& mesh, const std::vector<char>& mirrored,
                      const std::vector<double>& displacement) {
  const auto count = static_cast<std::size_t>(mesh.vertex_count());
  std::vector<Vec3> normal(count, Vec3::Zero()), around(count, Vec3::Zero());
  std::vector<double> number(count, 0.0);
  std::vector<char> left_out(count, 0);
  const auto u = [&](Index v) { return Vec3(Eigen::Map<const Vec3>(&displacement[3 * static_cast<std::size_t>(v)])); };
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    const mesh::Triangle& corners = mesh.triangles()[static_cast<std::size_t>(t)];
    for (int s = 0; s < 3; ++s) {
      const Index a = corners[(s + 1) % 3], b = corners[(s + 2) % 3];
      const auto v = static_cast<std::size_t>(corners[s]);
      normal[v] += mesh.area(t) * mesh.start_normal(t);
      around[v] += u(a) + u(b);
      number[v] += 2.0;
      if (mesh.neighbour(t, s) != no_index) continue;
      for (const Index end : {a, b}) left_out[static_cast<std::size_t>(end)] = 1;
    }
  }
  Dimple deepest;
  double largest = 0.0;
  for (std::size_t v = 0; v < count; ++v) {
    const Vec3 here = u(static_cast<Index>(v));
    largest = std::max(largest, here.norm());
    if ((left_out[v] != 0 && mirrored[v] == 0) || !(number[v] > 0.0)) continue;
    const double depth = std::abs(normal[v].normalized().dot(here - around[v] / number[v]));
    if (depth > deepest.depth) deepest = {depth, static_cast<Index>(v)};
  }
  if (largest > 0.0) deepest.depth /= largest;
  return deepest;
}

std::string dimple_warning(const input::Case& c, const energy::Sheet& sheet, const std::vector<double>& displacement,
                           double load_factor) {
  const bool corrected = sheet.options().membrane == energy::MembraneOperator::six_node_corrected;
  if (!corrected || !(c.analysis == input::Analysis::statics || c.analysis == input::Analysis::linear) ||
      !is_pressed(c))
    return "";
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  const Dimple dimple = deepest_dimple(mesh, mirrored_vertices(c, mesh), displacement);
  if (!(dimple.depth > depth_limit)) return "";
  const Vec3& x = mesh.positions()[static_cast<std::size_t>(dimple.vertex)];
  return fmt::format(
      "at load factor {:.4g} single vertices stand out from their neighbours, by {:.0f} % of the largest displacement "
      "at "
      "({:.4g}, {:.4g}, {:.4g}) m: "
      "where cells of a thin curved shell are larger than sqrt(R h), pressure makes dimples of them, and deflections "
      "may be "
      "several times too large; use cells of a third of that, or element.type = \"six_node\"",
      load_factor, 100.0 * dimple.depth, x[0], x[1], x[2]);
}

}  // namespace voile::record

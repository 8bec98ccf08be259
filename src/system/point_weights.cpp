#include "point_weights.hpp"

#include "base/group_list.hpp"

namespace voile::system {

namespace {

/// Which part of the area around each vertex is under the load.
std::vector<double> parts_under(const mesh::SurfaceMesh& mesh, const Load& load) {
  const auto count = static_cast<std::size_t>(mesh.vertex_count());
  if (load.group.empty()) return std::vector<double>(count, 1.0);
  std::vector<double> under(count, 0.0), around(count, 0.0);
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (const Index v : mesh.triangles()[t]) around[v] += mesh.area(t);
  for (const Index t : mesh.group(load.group, 2).triangles)
    for (const Index v : mesh.triangles()[t]) under[v] += mesh.area(t) / around[v];
  return under;
}

}  // namespace

void add_point_weights(const mesh::SurfaceMesh& mesh, const Load& load, const std::vector<PointMass>& masses,
                       const std::function<void(Index vertex, const Vec3& force)>& add) {
  if (masses.empty()) return;
  const std::vector<double> under = parts_under(mesh, load);
  const std::vector<std::string> groups = groups_of(load.group);
  for (const PointMass& m : masses) {
    const bool same = contains(groups, m.group);
    for (const Index v : mesh.group(m.group).places())
      if (under[v] > 0.0) add(v, (same ? 1.0 : under[v]) * m.mass * load.vector);
  }
}

}  // namespace voile::system

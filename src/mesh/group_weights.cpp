#include "group_weights.hpp"

#include <algorithm>
#include <numeric>

namespace voile::mesh {

std::vector<double> group_weights(const SurfaceMesh& mesh, const Group& group) {
  std::vector<double> weights(group.vertices.size(), 0.0);
  const auto add = [&](Index v, double part) {
    const auto at = std::lower_bound(group.vertices.begin(), group.vertices.end(), v);
    weights[static_cast<std::size_t>(at - group.vertices.begin())] += part;
  };
  for (const Index t : group.triangles) {
    const double area = mesh.area(t);
    for (const Index v : mesh.triangles()[t]) add(v, area);
  }
  for (const auto& [v, w] : group.segments) {
    const double length = (mesh.positions()[v] - mesh.positions()[w]).norm();
    add(v, length);
    add(w, length);
  }
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& w : weights) w = total > 0.0 ? w / total : 1.0 / static_cast<double>(weights.size());
  return weights;
}

}  // namespace voile::mesh

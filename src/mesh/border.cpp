#include "border.hpp"

#include <algorithm>

namespace voile::mesh {

std::vector<Segment> inner_border(const SurfaceMesh& mesh, const Group& group) {
  std::vector<char> within(static_cast<std::size_t>(mesh.triangle_count()), 0);
  for (const Index t : group.triangles) within[t] = 1;
  std::vector<Segment> border;
  for (const Index t : group.triangles)
    for (int s = 0; s < 3; ++s)
      if (const Index n = mesh.neighbour(t, s); n != no_index && !within[n]) {
        const Triangle& corners = mesh.triangles()[t];
        const auto [low, high] = std::minmax(corners[(s + 1) % 3], corners[(s + 2) % 3]);
        border.push_back({low, high});
      }
  for (const Joint& joint : mesh.joints()) {
    const auto is_within = [&](const TriangleSide& s) { return within[s.triangle] != 0; };
    const auto count = std::count_if(joint.sides.begin(), joint.sides.end(), is_within);
    if (count > 0 && count < static_cast<std::ptrdiff_t>(joint.sides.size())) border.push_back(joint.edge);
  }
  std::sort(border.begin(), border.end());
  return border;
}

bool is_clamped_border(const SurfaceMesh& mesh, const Joint& joint) {
  const auto is_among = [&](const std::vector<Segment>& edges) {
    return std::binary_search(edges.begin(), edges.end(), joint.edge);
  };
  return joint.sides.size() == 2 && is_among(mesh.data().borders) && !is_among(mesh.data().hinges);
}

}  // namespace voile::mesh

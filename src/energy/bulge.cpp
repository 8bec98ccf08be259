#include "bulge.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "chord_forms.hpp"

namespace voile::energy {

namespace {

/// Whether curvature is fitted to points beyond a crease: the sheet there says nothing of what bulges here.
bool reaches_over_crease(const Sheet& sheet, Index t, const CurvatureOperator& op) {
  constexpr int widest = 4;  // rings of triangles in any patch
  const mesh::SurfaceMesh& mesh = sheet.mesh();
  std::set<Index> left;
  for (const Index p : op.points)
    if (p < mesh.vertex_count()) left.insert(p);
  std::set<Index> seen{t};
  std::vector<Index> ring{t};
  for (int k = 0; k <= widest && !left.empty() && !ring.empty(); ++k) {
    std::vector<Index> next;
    for (const Index n : ring) {
      for (const Index v : mesh.triangles()[n]) left.erase(v);
      for (int s = 0; s < 3; ++s)
        if (const Index other = mesh.neighbour(n, s);
            other != no_index && !sheet.is_crease(n, s) && seen.insert(other).second)
          next.push_back(other);
    }
    ring = std::move(next);
  }
  return !left.empty();
}

}  // namespace

Bulge make_bulge(const Sheet& sheet, Index t, const std::array<Index, 3>& corners, const CurvatureOperator& op) {
  Bulge bulge;
  const bool curved = sheet.options().membrane == MembraneOperator::six_node_corrected;
  if (!curved || beside_crease(sheet, t) || reaches_over_crease(sheet, t, op)) return bulge;
  const mesh::Frame frame = sheet.frame(t);
  Vec3 form = Vec3::Zero();  // sum of l (x) l
  for (int i = 0; i < 3; ++i) {
    const Vec2 side =
        frame.to_plane(sheet.mesh().rest_corner(t, (i + 1) % 3)) - frame.to_plane(sheet.mesh().rest_corner(t, i));
    form += Vec3(side[0] * side[0], side[1] * side[1], side[0] * side[1]);
  }
  bulge.points.assign(corners.begin(), corners.end());
  bulge.weights.assign(3, 0.0);
  for (std::size_t k = 0; k < op.points.size(); ++k) {
    const double weight = form.dot(op.weights.col(static_cast<Eigen::Index>(k)));
    const auto corner = std::find(corners.begin(), corners.end(), op.points[k]);
    if (corner != corners.end()) {
      bulge.weights[static_cast<std::size_t>(corner - corners.begin())] += weight;
      continue;
    }
    bulge.points.push_back(op.points[k]);
    bulge.weights.push_back(weight);
  }
  return bulge;
}

}  // namespace voile::energy

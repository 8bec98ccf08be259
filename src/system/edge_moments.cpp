#include "edge_moments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "discretisation.hpp"
#include "energy/curvature.hpp"
#include "energy/edge_moment.hpp"
#include "energy/loads.hpp"
#include "energy/sheet.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

bool is_one_of(const std::vector<mesh::TriangleSide>& sides, const mesh::TriangleSide& at) {
  return std::find(sides.begin(), sides.end(), at) != sides.end();
}

bool holds_slope(const std::vector<RigidBody>& bodies, const mesh::TriangleSide& at) {
  return std::any_of(bodies.begin(), bodies.end(), [&](const RigidBody& b) { return is_one_of(b.slopes, at); });
}

/// Throws UserError for an edge that a moment cannot turn.
void require_free_edge(const Discretisation& on, const Load& load, const mesh::Segment& s,
                       const mesh::TriangleSide& at) {
  const mesh::SurfaceMesh& mesh = on.mesh();
  const char* wrong =
      mesh.neighbour(at.triangle, at.side) != no_index || mesh.is_joint(at.triangle, at.side)
          ? "lies inside the surface; a moment acts on a boundary edge"
      : on.patches().apex(at.triangle, at.side) != no_index
          ? "has its slope held by a [[support]], which takes up the moment; take the edge out of one of the groups"
      : is_one_of(on.constraints().elastic, at)
          ? "turns a [[hinge]]; give the hinge, whose stiffness is k, an `angle` less by the moment over k instead"
      : holds_slope(on.constraints().bodies, at) ? "turns with a [[rigid]] group; give the group its `moment` instead"
                                                 : nullptr;
  if (wrong)
    throw UserError(fmt::format("[[load]] group '{}' (follower_moment): the edge {}-{} {}", load.group,
                                mesh.data().vertex_tags[s[0]], mesh.data().vertex_tags[s[1]], wrong));
}

/// On a side of a triangle, local points. A couple where the element knows no slopes.
energy::EdgeMoment moment_on(const Discretisation& on, energy::CurvatureBuilder& curvatures,
                             const mesh::TriangleSide& at) {
  const mesh::Triangle& v = on.mesh().triangles()[at.triangle];
  const auto corner = [&](int k) { return v[static_cast<std::size_t>((at.side + k) % 3)]; };
  energy::EdgeMoment edge{{corner(1), corner(2), corner(0)}, {1.0, 0.0, -1.0}, Vec3::Zero()};
  if (auto free = energy::make_edge_moment(on.element_sheet(), curvatures, at.triangle, at.side))
    edge = std::move(*free);
  for (Index& p : edge.points) p = on.dofs().local().local_of[p];
  return edge;
}

}  // namespace

void add_edge_moments(const Discretisation& on, const Load& load, int factor, energy::FollowerTerm& term) {
  const mesh::SurfaceMesh& mesh = on.mesh();
  energy::CurvatureBuilder curvatures(on.element_sheet());
  std::map<Index, std::vector<int>> loaded;  // sides by triangle
  for (const mesh::Segment& s : mesh.group(load.group, 1).segments)
    for (const Index t : mesh.triangles_of_vertex(s[0]))
      if (const int side = mesh.side_of(t, s[0], s[1]); side >= 0) {
        require_free_edge(on, load, s, {t, side});
        loaded[t].push_back(side);
      }
  for (const auto& [t, corners, owned] : on.elements()) {
    const auto found = loaded.find(t);
    if (found == loaded.end()) continue;
    const mesh::Triangle& v = mesh.triangles()[t];
    for (const int side : found->second) {
      const double length =
          mesh.rest_length({v[static_cast<std::size_t>((side + 1) % 3)], v[static_cast<std::size_t>((side + 2) % 3)]});
      term.add_moment(moment_on(on, curvatures, {t, side}), t, load.magnitude * length, factor, owned);
    }
  }
}

}  // namespace voile::system

#include "hinges.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "voile/errors.hpp"

namespace voile::system {

namespace {

std::string place_of(const mesh::SurfaceMesh& mesh, const mesh::Segment& edge) {
  const Vec3 x = 0.5 * (mesh.positions()[edge[0]] + mesh.positions()[edge[1]]);
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) m", x[0], x[1], x[2]);
}

HingeEdge hinge_edge(const mesh::SurfaceMesh& mesh, const Hinge& hinge, const mesh::Segment& edge) {
  const std::vector<mesh::Joint>& joints = mesh.joints();
  const auto found = std::lower_bound(joints.begin(), joints.end(), edge,
                                      [](const mesh::Joint& j, const mesh::Segment& e) { return j.edge < e; });
  if (found != joints.end() && found->edge == edge) {
    if (found->sides.size() == 2) return {static_cast<Index>(found - joints.begin()), edge, found->sides.front()};
    throw UserError(fmt::format(
        "[[hinge]] group '{}': {} sheets meet at {}; a hinge has two, or one on the boundary: take the edge "
        "out of the group",
        hinge.group, found->sides.size(), place_of(mesh, edge)));
  }
  for (const Index t : mesh.triangles_of_vertex(edge[0])) {
    const int s = mesh.side_of(t, edge[0], edge[1]);
    if (s < 0) continue;
    if (mesh.neighbour(t, s) == no_index) return {static_cast<Index>(joints.size()) + 3 * t + s, edge, {t, s}};
    throw UserError(fmt::format(
        "[[hinge]] group '{}': the sheet is whole at {}; a restart takes the mesh of its run, so give that run the "
        "[[hinge]], or start anew",
        hinge.group, place_of(mesh, edge)));
  }
  throw UserError(fmt::format("[[hinge]] group '{}': there is no edge at {}", hinge.group, place_of(mesh, edge)));
}

}  // namespace

std::vector<HingeEdge> edges_of(const mesh::SurfaceMesh& mesh, const Hinge& hinge) {
  std::vector<HingeEdge> edges;
  for (mesh::Segment edge : mesh.group(hinge.group, 1).segments) {
    std::sort(edge.begin(), edge.end());
    edges.push_back(hinge_edge(mesh, hinge, edge));
  }
  const auto less = [](const HingeEdge& a, const HingeEdge& b) { return a.number < b.number; };
  const auto same = [](const HingeEdge& a, const HingeEdge& b) { return a.number == b.number; };
  std::sort(edges.begin(), edges.end(), less);
  edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
  return edges;
}

std::map<Index, HingedEdge> hinged_edges(const mesh::SurfaceMesh& mesh, const std::vector<Hinge>& hinges) {
  std::map<Index, HingedEdge> all;
  for (const Hinge& hinge : hinges)
    for (const HingeEdge& e : edges_of(mesh, hinge))
      if (!all.try_emplace(e.number, HingedEdge{e, hinge.stiffness}).second)
        throw UserError(
            fmt::format("[[hinge]] group '{}': some of its edges belong to another hinge; take them out of "
                        "one of the groups",
                        hinge.group));
  return all;
}

}  // namespace voile::system

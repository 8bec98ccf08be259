// What remeshing must keep of a mesh: lines of sides and corners on them.
#pragma once

#include <vector>

#include "half_edges.hpp"
#include "remesh.hpp"

namespace voile::adapt {

struct Features {
  /// Per side (half_edges.hpp): 0 inside, else the class of the line it lies on: what kind of line, and its groups.
  std::vector<int> side_class;
  std::vector<std::vector<int>> groups_of_side_class;  ///< groups of dimension 1, ascending; of class 0: none
  std::vector<int> triangle_class;                     ///< per triangle
  std::vector<std::vector<int>> groups_of_triangle_class;
  /// Per group: its vertices that none of its segments or triangles has. They stay.
  std::vector<std::vector<Index>> single_vertices;
  std::vector<char> corner;      ///< per vertex: stays in its place
  std::vector<char> on_feature;  ///< per vertex
  std::vector<char> pinched;     ///< per vertex: two fans of triangles touch in it
};

/// A side within a chart at rest and in texture coordinates: the corners of both triangles agree.
[[nodiscard]] bool same_chart(const mesh::SurfaceMesh& mesh, Index t, int s);
/// Whether a rest dihedral angle at that side is above the limit [rad].
[[nodiscard]] bool is_crease(const mesh::SurfaceMesh& mesh, Index t, int s, double limit);

[[nodiscard]] Features find_features(const mesh::SurfaceMesh& mesh, const HalfEdges& edges, const Limits& limits,
                                     double crease);

}  // namespace voile::adapt

// Half-edges of triangles by number.
//
// Symbols   h = 3 t + s   side s of triangle t, opposite to its corner h, and that corner
//           origin, dest  ends of the side as the triangle runs round it; apex: the vertex of corner h
// Source: M. Botsch, L. Kobbelt, M. Pauly, P. Alliez & B. Levy, Polygon Mesh Processing (2010), 2.
#pragma once

#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::adapt {

inline Index next(Index h) {
  return h % 3 == 2 ? h - 2 : h + 1;
}
inline Index prev(Index h) {
  return h % 3 == 0 ? h + 2 : h - 1;
}

struct HalfEdges {
  std::vector<Index> vertex;  ///< per corner
  std::vector<Index> twin;    ///< per side: the same side in the neighbour, or no_index

  [[nodiscard]] Index origin(Index h) const { return vertex[next(h)]; }
  [[nodiscard]] Index dest(Index h) const { return vertex[prev(h)]; }
  [[nodiscard]] Index apex(Index h) const { return vertex[h]; }
  /// Next side that leaves the origin of h, counter-clockwise or clockwise; no_index beyond the boundary.
  [[nodiscard]] Index left(Index h) const { return twin[prev(h)]; }
  [[nodiscard]] Index right(Index h) const { return twin[h] == no_index ? no_index : next(twin[h]); }
  /// The first side that leaves the origin of h counter-clockwise: h itself inside, that on the boundary else.
  [[nodiscard]] Index first_around(Index h) const {
    Index e = h;
    while (twin[e] != no_index) {
      e = next(twin[e]);
      if (e == h) break;
    }
    return e;
  }
};

inline HalfEdges half_edges(const mesh::SurfaceMesh& mesh) {
  HalfEdges e;
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      const Index n = mesh.neighbour(t, s);
      e.vertex.push_back(mesh.triangles()[t][s]);
      e.twin.push_back(n == no_index ? no_index : 3 * n + mesh.side_in_neighbour(t, s));
    }
  return e;
}

}  // namespace voile::adapt

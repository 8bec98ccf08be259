// Everything that can touch: the sheet's vertices, edges and triangles, and those of the obstacles.
//
// Points are numbered through: first the vertices of the mesh, then those of the obstacles, one after the other. An
// obstacle may have triangles, edges without triangles (the axis of a capsule) or single points (a ball's centre): its
// offset is then the radius. A body is an obstacle or a part of the sheet that has rules of its own: triangles with
// what belongs to them, or a curve, which is its points with all edges and triangles that touch them.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::contact {

struct Body {
  std::string name;
  double thickness = 0.0;  ///< its surface lies half of this before its triangles, edges or points [m]
};

/// What holds between two bodies.
struct Rule {
  bool touch = true;
  double friction = 0.0;  ///< coefficient
};

struct Edge {
  std::array<Index, 2> points;
  int body = 0;
  double rest_length_squared = 0.0;  ///< [m^2]
  bool bare = false;                 ///< of no triangle
};

struct Face {
  std::array<Index, 3> points;
  int body = 0;
};

/// Pairs of neighbours of the sheet, see neighbours.hpp.
struct Neighbours {
  std::vector<char> concerned;  ///< per sheet point: it is in such a pair; empty: there are none
  /// Fraction of offset and activation distance that holds, by the points of a pair: of points and triangles, of edges.
  std::map<std::array<Index, 4>, double> of_faces, of_edges;
};

struct Surface {
  Index sheet_points = 0;  ///< how many points are the mesh's
  std::vector<Vec3> rest;  ///< positions at the start [m]
  std::vector<int> body_of_point;
  std::vector<double> area;        ///< per point: a third of its triangles' [m^2]
  std::vector<Edge> edges;         ///< the sheet's first
  std::vector<Face> faces;         ///< the sheet's first
  std::vector<Index> bare_points;  ///< of no triangle and no edge but an obstacle, or ends of bare edges
  Index sheet_edges = 0, sheet_faces = 0;
  std::vector<double> face_area;  ///< [m^2]
  std::vector<Body> bodies;
  std::vector<std::vector<Rule>> rules;  ///< symmetric table by body
  Neighbours neighbours;

  [[nodiscard]] Index points() const { return static_cast<Index>(rest.size()); }
  /// Per sheet point: points with the same number become one when their seam is welded, so figures that share one are
  /// no pair; empty: none do.
  std::vector<Index> joined;
  [[nodiscard]] bool same(Index p, Index q) const {
    return p == q || (!joined.empty() && is_sheet(p) && is_sheet(q) && joined[p] == joined[q]);
  }
  [[nodiscard]] bool is_sheet(Index point) const { return point < sheet_points; }
  [[nodiscard]] double offset(int a, int b) const { return 0.5 * (bodies[a].thickness + bodies[b].thickness); }
};

/// The sheet alone, all of it body 0 (named "sheet"), unless `body_of_triangle` (empty: none) gives other bodies.
/// `body_of_vertex` (empty: none): of a curve through the vertex, or -1. It goes before that of triangles; an edge or
/// triangle that touches several curves belongs to the last of these bodies.
[[nodiscard]] Surface make_surface(const mesh::SurfaceMesh& mesh, std::vector<Body> bodies,
                                   const std::vector<int>& body_of_triangle,
                                   const std::vector<int>& body_of_vertex = {});

/// Of the sheet's edges at rest. [m]
[[nodiscard]] double mean_edge(const Surface& surface);

/// Appends a rigid or deforming thing: points with triangles, bare edges, or alone. Returns its first point.
Index append(Surface& surface, int body, const std::vector<Vec3>& points, const std::vector<mesh::Triangle>& triangles,
             const std::vector<mesh::Segment>& bare_edges);

}  // namespace voile::contact

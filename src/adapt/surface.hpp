// The triangulation while it is being changed: half-edges, rest corners, classes of lines, what contact allows.
#pragma once

#include <array>
#include <vector>

#include "chart_search.hpp"
#include "features.hpp"
#include "half_edges.hpp"
#include "open_seams.hpp"
#include "remesh.hpp"

namespace voile::adapt {

/// Everything per corner, side, triangle and vertex; removed ones stay with their numbers, marked.
struct Surface : HalfEdges {
  Surface(const mesh::SurfaceMesh& mesh, const RestSurface& rest, const std::vector<Vec3>& places,
          const std::vector<double>& size, const Limits& limits, const Options& options);

  // Corners and sides
  std::vector<Vec3> rest;     ///< [m]
  std::vector<Vec2> texture;  ///< empty: none
  std::vector<int> side_class;
  // Triangles
  std::vector<char> dead, frozen, touched;
  std::vector<int> triangle_class;
  std::vector<double> moved, allowed;      ///< [m] what its points have moved at most, what they may; empty: no contact
  std::vector<Index> rest_hint, old_hint;  ///< triangles of the first and of the old mesh near to it
  // Vertices
  std::vector<char> gone, fixed, on_feature, dirty;
  std::vector<Vec3> place;     ///< [m]
  std::vector<double> size;    ///< [m]
  std::vector<Index> old;      ///< old vertex if it has not moved
  std::vector<Index> leaving;  ///< a side that leaves it

  const RestSurface* first;
  ChartSearch search;  ///< in the old mesh
  std::vector<mesh::Triangle> old_triangles;
  const std::vector<double>* old_size;
  Features features;  ///< of the old mesh
  OpenSeams open_seams;
  bool only_splits;  ///< which move nothing
  Counts counts;

  [[nodiscard]] Index triangle_slots() const { return static_cast<Index>(dead.size()); }
  [[nodiscard]] Index vertex_slots() const { return static_cast<Index>(gone.size()); }
  [[nodiscard]] Index live_vertices() const;
  [[nodiscard]] Index side_count() const { return static_cast<Index>(twin.size()); }
  /// Each pair of sides once: the lower one, alive.
  [[nodiscard]] bool is_edge(Index h) const { return !dead[h / 3] && (twin[h] == no_index || twin[h] > h); }
  /// The side beyond an edge: of the neighbour, or where the edge is sewn, of the other panel; no_index if there is none.
  [[nodiscard]] Index across(Index h) const;
  /// Whether a side stays: of frozen triangles, or of an open seam whose other side is not to be found.
  [[nodiscard]] bool locked(Index h) const;
  /// Rest length over wanted size, the longer side of a seam, open or not.
  [[nodiscard]] double metric_length(Index h) const;
  [[nodiscard]] double rest_length(Index h) const { return (rest[prev(h)] - rest[next(h)]).norm(); }
  [[nodiscard]] Vec3 rest_normal(Index t) const;
  /// Number of edges of the vertex that side e leaves, and whether it is inside.
  struct Valence {
    int edges = 0;
    bool inside = true;
  };
  [[nodiscard]] Valence valence(Index e) const;
  /// Whether an edge joins the origin of e to vertex w.
  [[nodiscard]] bool joined(Index e, Index w) const;

  /// Whether an edge between two vertices could be made: one that coincides with no other when open seams are welded.
  [[nodiscard]] bool can_join(Index v, Index w) const;

  /// Halves an edge, and what it is sewn to; the new vertices, of which the second may be no_index.
  std::array<Index, 2> split(Index h);
  /// Turns the edge inside its two triangles.
  void flip(Index h);
  /// Wanted size at a rest position [m]; `hint`: old triangle near to it.
  [[nodiscard]] double size_at(const Vec3& position, Index& hint) const;

  /// A small offset at rest [m] as triangle t has turned and stretched it.
  [[nodiscard]] Vec3 carried(Index t, const Vec3& offset) const;

  /// What contact leaves of a set of triangles, and charging it.
  struct Budget {
    double moved = 0.0, allowed = 0.0;
  };
  [[nodiscard]] Budget budget(const std::vector<Index>& triangles) const;
  void charge(const std::vector<Index>& triangles, const Budget& budget, double displacement);

 private:
  Index halve(Index h);
  Vec3 room_off_edge(Index h, const Vec3& here, const Vec3& there);
  Index half_split(Index h, Index m, const Vec3& at);
  [[nodiscard]] Index boundary_side(Index a, Index b) const;
  void link(Index a, Index b);
  Index add_triangle_like(Index t);
};

}  // namespace voile::adapt

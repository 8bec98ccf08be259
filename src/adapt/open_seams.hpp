// Open seams while the mesh changes: their two sides are split together, so that they stay node by node.
//
// Symbols   class   vertices that become one when all open seams are welded
//           sewn    a side on the boundary is sewn to the other one whose ends are of the same classes: they become one edge
// Vertices of open seams stay. Edges are known by their ends, whose numbers stay while those of sides change.
// Theory: docs/theory/remeshing.md, operations.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "half_edges.hpp"

namespace voile::adapt {

/// A part of an old side.
struct OldShare {
  Index side = no_index;
  double fraction = 0.0;  ///< from its origin to its end
};

class OpenSeams {
 public:
  OpenSeams(const mesh::SurfaceMesh& mesh, const HalfEdges& edges);

  /// An edge of an open seam.
  struct Edge {
    std::array<Index, 2> other;  ///< what its ends become one with, the lower end first
    int seam = -1;               ///< -1: not known, so that it must stay
    double length = 0.0;         ///< of the seam that it stands for [m]
    Index side = no_index;       ///< the old side that it is part of
    std::array<double, 2> fraction{};
  };
  [[nodiscard]] bool empty() const { return edges_.empty(); }
  [[nodiscard]] const std::vector<mesh::Seam>& seams() const { return seams_; }
  /// Nothing if the edge is not sewn.
  [[nodiscard]] const Edge* find(Index a, Index b) const;
  /// Whether a vertex must stay where it is.
  [[nodiscard]] bool holds(Index v) const { return held_.count(v) > 0; }
  /// The class of a vertex.
  [[nodiscard]] std::vector<Index> members(Index v) const;
  /// Where a vertex that a split has made lies; nothing for others.
  [[nodiscard]] std::optional<OldShare> origin_of(Index v) const;

  /// The edge a-b and the one that it is sewn to have been halved by new vertices, m and n.
  void split(Index a, Index b, Index m, Index n);

 private:
  using Ends = std::pair<Index, Index>;
  using Pair = std::array<Index, 2>;
  static double station_between(const mesh::Seam& seam, const Pair& a, const Pair& b, double length);
  void halve(Index a, Index b, Index m, Index n);
  /// Takes from the fraction of a pair at the end of a halved edge.
  double take(int seam, Index v, Index w, double length);

  std::map<Ends, Edge> edges_;
  std::map<Index, std::vector<Index>> class_of_;  ///< of those with more than one member
  std::map<Index, OldShare> held_;                ///< side no_index: an old vertex
  std::vector<mesh::Seam> seams_;
};

}  // namespace voile::adapt

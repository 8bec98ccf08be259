// Edges that pierce triangles, and the movements that undo it; private to src/untangle.
//
// Symbols   t           fraction of the edge at which it meets the triangle's plane
//           b_k         weights of the triangle's corners there
//           E, N, R_k   unit vectors of the edge, of the triangle's normal and of the line of intersection into each
//                       face of the edge
//           G           = sum_k R_k - (E.R_k)/(E.N) N, along which the edge moves to shorten the line
// Source: Volino, Magnenat-Thalmann, Resolving surface collisions through intersection contour minimization, ACM TOG 25
// (2006).
#pragma once

#include <set>
#include <vector>

#include "tangle.hpp"

namespace voile::untangle {

/// An edge meets triangle `face`.
struct Piercing {
  Segment edge;
  Index face;
  double t;
  Vec3 weights;  ///< b_k
};

/// Every edge of one triangle of a pair that pierces the other, once.
[[nodiscard]] std::vector<Piercing> find_piercings(const Tangle& tangle, const FacePairs& pairs);

/// Where the border of one sheet ends a line of intersection on another close to the border of that: edges to cut, as
/// the two sides of the line must not count as one region for the sake of the strip in between.
[[nodiscard]] std::set<Segment> border_gaps(const Tangle& tangle, const std::vector<Piercing>& found);

/// What brings one end of an edge to the other side of the triangle. [m]
[[nodiscard]] Vec3 back_through(const Tangle& tangle, const Piercing& p, Index end);

/// What shortens the line of intersection where it ends in, or passes, an edge. [m]
[[nodiscard]] Vec3 along_contour(const Tangle& tangle, const Piercing& p);

}  // namespace voile::untangle

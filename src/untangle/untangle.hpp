// Repair of shallow intersections and of lacking gaps in a start, by geometry alone: nothing is said about forces.
//
// Symbols   x_i, P_i  positions [m] and projectors onto the directions in which point i may move (zero for obstacles)
//           c_i       signed weights of the two places of a pair: w = sum_i c_i x_i joins them                    [m]
// A correction that shall change w by D along n = D/|D| moves point i by c_i P_i n |D| / sum_j c_j^2 n.P_j n.
// Rounds, each begun with a list of intersecting triangles from outside, alternate
//   solids      points of the sheet inside a closed mesh are moved to its nearest surface; balls, capsules and
//               half-spaces push by distance
//   regions     edges that pierce another piece of the sheet, or an obstacle, cut their own piece into regions on two
//               sides; the side of less area is the wrong one, and the edge's end there is moved back through the
//               triangle
//   contours    other piercing edges are moved so that the line of intersection becomes shorter: with the unit vectors
//               E of the edge, N of the triangle, R_k of the line into each face of the edge, relative to the triangle
//               along  G = sum_k R_k - (E.R_k)/(E.N) N
//   coincident  pieces of the sheet that lie exactly in one another have no sides: the later one in the mesh is moved
//               by half the distance along the normal of the earlier one, which is moved by half the other way
//   gaps        once nothing intersects, pairs that are too near are pushed apart
// Sources: Baraff, Witkin, Kass, Untangling Cloth, ACM TOG 22 (2003); Volino, Magnenat-Thalmann, Resolving surface
// collisions through intersection contour minimization, ACM TOG 25 (2006).
#pragma once

#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "contact/contact_set.hpp"
#include "contact/surface.hpp"

namespace voile::untangle {

using namespace contact;

struct UntangleOptions {
  double activation_distance = 1e-3;  ///< parts that are nearer are moved to about this [m]
  double limit = 0.0;                 ///< no vertex may move further: the intersection is not shallow [m]
  int rounds = 100;                   ///< at most
};

struct UntangleResult {
  bool done = false;                                     ///< nothing intersects and every gap is positive
  int rounds = 0;                                        ///< used
  Index moved = 0;                                       ///< vertices
  double farthest = 0.0;                                 ///< movement of a vertex [m]
  std::size_t left = 0;                                  ///< intersecting pairs after the last round
  double gap = std::numeric_limits<double>::infinity();  ///< smallest after it [m]; infinite: none below the distance
};

/// Intersecting triangles at given positions of all points, as numbers of Surface::faces; higher numbers stand for
/// things that have no faces there (balls, capsules).
using FindIntersections = std::function<std::vector<std::pair<Index, Index>>(const std::vector<Vec3>&)>;

/// Moves sheet points in x (positions of all points). `free`: P_i per sheet point. Pairs of bodies that ignore each
/// other must not be in what `find` returns. Not collective, deterministic; x belongs to the caller and holds the last
/// round, also if it failed. Throws InternalError if x or `free` has the wrong length, and what `find` throws.
[[nodiscard]] UntangleResult untangle(const Surface& surface, const std::vector<Plane>& planes,
                                      const std::vector<Mat3>& free, const FindIntersections& find,
                                      const UntangleOptions& options, std::vector<Vec3>& x);

}  // namespace voile::untangle

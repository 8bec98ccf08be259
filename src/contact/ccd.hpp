// Conservative continuous collision detection: how far a pair may go along straight paths without touching.
//
// Symbols   x_i, p_i  vertices and their displacements over the step                          [m]
//           xi        offset that the distance must stay above                                [m]
//           l         bound on how fast the distance can fall: the largest displacements of both figures added, the
//                     mean of all displacements taken away first                              [m]
// From a place with gap g the pair may advance by a fraction 0.8 g/l of the step, whatever happens there; advances add up
// until the gap has fallen below a fifth of the first one (it stays above a 25th). Double precision; the answer is
// never later than the contact. Source: additive CCD, Li, Kaufman, Jiang, Codimensional Incremental Potential Contact,
// ACM TOG 40 (2021).
#pragma once

#include "distance.hpp"

namespace voile::contact {

enum class PairKind : unsigned char { point_triangle, edge_edge, point_edge };

[[nodiscard]] Closest closest(PairKind kind, const std::array<Vec3, 4>& x);
/// closest(kind, x).distance to round-off, for less. [m]
[[nodiscard]] double distance(PairKind kind, const std::array<Vec3, 4>& x);
/// Lower bound of the distance, or a negative number: how far apart the figures are along a coordinate axis. [m]
[[nodiscard]] double axis_distance(PairKind kind, const std::array<Vec3, 4>& x);

/// Fraction of the step, at most `limit`, that the pair may take. 0 if it touches already.
[[nodiscard]] double step_fraction(PairKind kind, std::array<Vec3, 4> x, std::array<Vec3, 4> p, double xi,
                                   double limit = 1.0);

}  // namespace voile::contact

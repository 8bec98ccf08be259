// One operation at a time, done only if shape, lines, sizes and contact allow it.
#pragma once

#include "star.hpp"
#include "surface.hpp"

namespace voile::adapt {

enum class Outcome { done, feature, quality, clearance };

/// Largest rest dihedral angle that an operation may make inside a smooth piece [rad]: well below that of a crease.
inline constexpr double largest_rest_dihedral = 0.436;

/// Removes a vertex into ring vertex k of its star. `sizes`: whether lengths of new edges count.
Outcome try_collapse(Surface& s, const Star& star, int k, const Options& options, bool sizes = true);
/// Removes either end of an edge, preferably a new one.
Outcome try_collapse_edge(Surface& s, Index h, const Options& options);

/// A triangle that is better than this [rad] need not be kept as good when a neighbour gains.
inline constexpr double good_angle = 0.6;  // 34 degrees

enum class FlipRule { delaunay, valence, none };
/// Turns an edge if the rule wants it. Outcome::feature also where it need not be turned.
Outcome try_flip(Surface& s, Index h, const Options& options, FlipRule rule);

/// Moves an inner vertex to the mean of its triangles' centroids, weighted by area over squared size.
Outcome try_smooth(Surface& s, Index v, const Options& options);
/// Moves an inner vertex to a point of its tangent plane, if no angle falls below `angle` [rad] or what it was.
Outcome try_move(Surface& s, const Star& star, const Fan& fan, const Vec2& target, double angle);

/// Moves an inner vertex so that its shortest edge gets as long as `options.shortest`, or nearer to that by a share worth it, and none
/// longer than `options.longest_after`, unless one was.
Outcome try_lengthen(Surface& s, Index v, const Options& options);

/// Moves a vertex along a straight feature line to where both its edges are as long as wanted.
Outcome try_slide(Surface& s, Index v, const Options& options);

/// Removes a vertex of an edge on a straight feature line whose neighbours there come nearer first, so that the edges left are as
/// long as each other and none longer than `options.longest_at_last`, unless one was.
Outcome try_thin(Surface& s, Index h, const Options& options);

/// Adds an outcome to the counts of what was refused.
void count(Counts& counts, Outcome outcome);

}  // namespace voile::adapt

// One operation at a time, done only if shape, lines, sizes and contact allow it.
#pragma once

#include "star.hpp"
#include "surface.hpp"

namespace voile::adapt {

enum class Outcome { done, feature, quality, clearance };

/// Largest rest dihedral angle that an operation may make inside a smooth piece [rad]: well below that of a crease.
inline constexpr double largest_rest_dihedral = 0.436;

struct CollapseRule {
  bool sizes = true;   ///< whether lengths of new edges count
  double angle = 0.0;  ///< [rad] that new triangles must have, whatever there was
};
/// Removes a vertex into ring vertex k of its star.
Outcome try_collapse(Surface& s, const Star& star, int k, const Options& options, const CollapseRule& rule = {});
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

/// Moves an inner vertex so that its shortest edge gets as long as `options.shortest`, or nearer to that by a fraction worth it, and none
/// longer than `options.longest_after`, unless one was.
Outcome try_lengthen(Surface& s, Index v, const Options& options);

/// Moves a vertex along a straight feature line to where both its edges are as long as wanted.
Outcome try_slide(Surface& s, Index v, const Options& options);

/// Moves a vertex of a straight feature line half-way to its neighbour `end` there, if no angle falls below `angle` [rad].
Outcome try_slide_towards(Surface& s, Index v, Index end, double angle);

/// Removes an edge into its middle, on straight lines too: into either end, edges of twice its length could be made. None of those made
/// is longer than `options.longest_at_last`.
Outcome try_merge(Surface& s, Index h, const Options& options);

/// Adds an outcome to the counts of what was refused.
void count(Counts& counts, Outcome outcome);

}  // namespace voile::adapt

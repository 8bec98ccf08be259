// Neighbours that lie nearer to each other at rest than contact reaches, as across a sliver.
//
// Symbols   D    distance of a pair in the rest shape [m];  R = offset + activation distance, which it should exceed [m]
// Two figures of the sheet are neighbours if a chain of triangles (or edges) joins them that all come nearer than
// R/room to the first: they lie in the same piece of the sheet within that ball. Two sheets one above the other never
// do. Beside joints of sheets chains reach further, through the edge of a wedge. Such a pair keeps the fraction
// room D/R < 1  of its offset and of its activation distance: it feels nothing at rest nor in moderate bending, and still
// can never intersect.
// Theory: docs/theory/contact.md, barrier.
#pragma once

#include "surface.hpp"

namespace voile::contact {

/// Fraction of its rest distance from which a pair of neighbours feels each other.
inline constexpr double room_between_neighbours = 0.7;

/// All such pairs of the sheet, in the rest shape. Not collective.
[[nodiscard]] Neighbours find_neighbours(const Surface& surface, double activation_distance);

}  // namespace voile::contact

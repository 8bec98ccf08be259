// Slits: where an outline goes out and back on the same way, as notches are cut. Each side may be a line of its own, and programs
// that round places leave the sides apart, or crossed, by some micrometres.
#pragma once

#include <vector>

#include "curve.hpp"

namespace voile::pattern {

/// Ends of curves meet if they are nearer than this fraction of the longest one.
constexpr double same_place = 1e-5;

/// Takes lines that are there twice out, of which one end alone is where other curves end too: that end goes to `slits`. Before
/// curves are joined, as more than two would meet there. In the file's units; not collective.
void take_out_double_lines(std::vector<Curve>& curves, std::vector<Vec2>& slits);

/// Takes slits out of a closed outline; where they began goes to `slits`. In the file's units; not collective.
void take_out_slits(std::vector<Curve>& outline, std::vector<Vec2>& slits);

}  // namespace voile::pattern

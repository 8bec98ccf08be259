// Closed polygons: what is wrong with them, and how large pieces are.
#pragma once

#include <optional>
#include <vector>

#include "voile/pattern/pattern.hpp"

namespace voile::pattern {

/// Two sides of a polygon that have a point in common, other than the corner of neighbours. Side i begins at point i.
struct Crossing {
  std::size_t first, second;
  Vec2 place;
};

/// The first crossing of a closed polygon, if any. Neighbours cross where one folds back onto the other.
[[nodiscard]] std::optional<Crossing> find_crossing(const std::vector<Vec2>& points);

struct Extent {
  Vec2 low, high;
};

/// Bounding box of a piece, of points on its curves. [m]
[[nodiscard]] Extent extent_of(const Piece& piece);

}  // namespace voile::pattern

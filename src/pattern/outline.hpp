// Closed polygons: what is wrong with them, and how large pieces are.
#pragma once

#include <optional>
#include <vector>

#include "pattern.hpp"

namespace voile::pattern {

/// Closed polygons; points, and the sides that begin at them, count through all.
using Polygons = std::vector<std::vector<Vec2>>;

/// Two sides that have a point in common, other than the corner of neighbours.
struct Crossing {
  std::size_t first, second;
  Vec2 place;
};

/// The first crossing of closed polygons, if any. Neighbours cross where one folds back onto the other.
[[nodiscard]] std::optional<Crossing> find_crossing(const Polygons& loops);

/// Whether a polygon goes round a point.
[[nodiscard]] bool is_inside(const std::vector<Vec2>& polygon, const Vec2& x);

/// A polygon that is no hole: it lies inside of another hole, or else outside of the outline.
struct Stray {
  std::size_t loop;
  std::optional<std::size_t> hole{};
};

/// The first of polygons that do not cross which is no hole of the one that is the outline.
[[nodiscard]] std::optional<Stray> find_stray(const Polygons& loops, std::size_t outline);

/// Points that show the shape of some curves that follow each other.
[[nodiscard]] std::vector<Vec2> polygon_of(const std::vector<Curve>& curves);

struct Extent {
  Vec2 low, high;
};

/// Bounding box of a piece, of points on its curves. [m]
[[nodiscard]] Extent extent_of(const Piece& piece);

}  // namespace voile::pattern

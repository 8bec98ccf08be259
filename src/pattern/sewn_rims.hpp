// Where the rims of pieces that a mesh draws are sewn to each other; private to src/pattern.
//
// Symbols   s   arc length along a rim from its first point [m]
// Points of rims that meet make intervals that meet; where those follow each other on both rims they are one seam, divided
// where either rim has a corner.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "pattern.hpp"

namespace voile::pattern {

/// A closed polygon round a piece or a hole in it.
struct Rim {
  std::size_t piece = 0;
  std::vector<Index> vertices;  ///< of the file, one for each point
  std::vector<Vec2> points;     ///< [m]
  std::vector<double> s;        ///< of each point, and the whole length at the end [m]
  std::vector<double> breaks;   ///< where edges begin, ascending, from 0 to the length [m]

  [[nodiscard]] double length() const { return s.back(); }
  /// Mean distance of its points. [m]
  [[nodiscard]] double spacing() const { return length() / static_cast<double>(points.size()); }
  [[nodiscard]] Vec2 at(double s) const;
  /// The break nearest to s if it is near, or else s as a new one. 0 and the length stay apart.
  double break_near(double s);
  /// The curve from one break to the next; straight pieces of it are one line.
  [[nodiscard]] Curve curve(std::size_t edge) const;
};

/// A place of a rim, a point or between two of them.
struct RimPlace {
  std::size_t rim = 0;
  double s = 0.0;
};

/// Part of a rim, between neighbouring breaks, that is sewn to another such part.
struct RimSeam {
  std::array<std::size_t, 2> rims, edges;  ///< `edges`: of each rim, counted from its first break
  bool is_along = false;                   ///< both run the same way
};

/// `meet[r][i]`: places that point i of rim r is sewn to. Adds breaks where seams begin and end. Not collective.
[[nodiscard]] std::vector<RimSeam> find_rim_seams(std::vector<Rim>& rims,
                                                  const std::vector<std::vector<std::vector<RimPlace>>>& meet);

}  // namespace voile::pattern

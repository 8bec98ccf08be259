// Closed meshes among the obstacles, and how a sheet gets out of them; private to src/untangle.
//
// A mesh is closed if every directed edge has its reverse exactly once. A point is inside where the winding number of
// the mesh around it is not zero, and is then moved to the nearest point outside. A piece of the sheet with a point
// deeper inside than the limit may belong there, as in a container: it is left, and the sides of its line of
// intersection decide (regions.hpp).
#pragma once

#include <set>
#include <utility>
#include <vector>

#include "piercing.hpp"

namespace voile::untangle {

/// A closed mesh among the obstacles.
struct Solid {
  int body;
  double offset;  ///< against the sheet [m]
  std::vector<mesh::Triangle> triangles;
};

/// An edge of the sheet through a solid with both ends outside: its point at fraction t is moved by `way` to be outside
/// too.
struct Lift {
  Segment edge;
  double t;
  Vec3 way;  ///< [m]
};

class Solids {
 public:
  explicit Solids(const Surface& surface);

  /// Moves points of the sheet that are inside, and notes which pieces are too deep for that.
  void leave(Tangle& tangle, const FacePairs& pairs);
  /// Whether an edge of the sheet passes through a solid that the sheet has left: both its ends are on the right side.
  [[nodiscard]] bool are_passed(const Tangle& tangle, const Piercing& p) const;
  /// For every edge and solid that it passes, the way of the middle of what is inside.
  [[nodiscard]] std::vector<Lift> lifts(const Tangle& tangle, const std::vector<Piercing>& found) const;

 private:
  void leave(Tangle& tangle, const Solid& solid, const std::set<Index>& crossing);
  /// Null: the body is not closed.
  [[nodiscard]] const Solid* find(int body) const;

  std::vector<Solid> solids_;
  std::set<std::pair<int, Index>> deep_;  ///< bodies and pieces too deep in them to be moved out
};

}  // namespace voile::untangle

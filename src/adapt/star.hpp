// The triangles around a vertex, as fans in the plane: what removing or moving the vertex would do to them.
//
// Symbols   e_i     sides that leave the vertex, counter-clockwise;  r_i the vertices at their ends
//           fan     the triangles between two feature lines of the vertex, or all of them: one chart
// A fan is laid into its mean tangent plane; its ring of vertices and places stays, its centre moves or becomes one of the
// ring. Displacement: the largest distance in space between the two fans at equal points of the plane. The difference is
// linear between the corners of the overlay, so these are all that is looked at.
// Theory: docs/theory/remeshing.md, operations.
#pragma once

#include <vector>

#include "surface.hpp"

namespace voile::adapt {

struct Star {
  Index vertex = no_index;
  std::vector<Index> spokes;  ///< sides that leave the vertex and have a triangle to their left
  std::vector<Index> ring;    ///< r_0 ..: as many as spokes, one more on the boundary
  bool closed = true;
  [[nodiscard]] int triangles() const { return static_cast<int>(spokes.size()); }
};

[[nodiscard]] Star star_of(const Surface& s, Index v);

/// The first spoke on a feature line other than k, or -1.
[[nodiscard]] int other_line(const Surface& s, const Star& star, int k);

struct Fan {
  std::vector<int> triangles;  ///< of the star, in order
  std::vector<int> ring;       ///< of the star: one more than triangles, or as many where it is closed
  bool closed = true;
  Vec3 normal;
  std::vector<Vec3> rest;   ///< of the ring [m]
  std::vector<Vec2> plane;  ///< of the ring [m]
  std::vector<Vec3> place;  ///< of the ring [m]
  Vec3 centre_rest, centre_place, origin, e1, e2;
  Vec2 centre;
  [[nodiscard]] Vec2 to_plane(const Vec3& x) const { return {(x - origin).dot(e1), (x - origin).dot(e2)}; }
  [[nodiscard]] int size() const { return static_cast<int>(ring.size()); }
  /// Triangles of the fan: ring[i], ring[i+1], centre.
  [[nodiscard]] int triangle_count() const { return static_cast<int>(triangles.size()); }
};

/// The fan of `count` triangles of a star from `from` on.
[[nodiscard]] Fan make_fan(const Surface& s, const Star& star, int from, int count);

/// Displacement [m] if the centre goes to a point of the plane with a place in space; `at`: the ring vertex that the centre
/// becomes, or -1.
[[nodiscard]] double displacement(const Fan& fan, const Vec2& centre, const Vec3& place, int at);

/// The triangle of a fan with this centre that a point of the plane lies in, or nearly: ring members i and j, and weights of
/// the centre and of these.
struct InFan {
  int i = 0, j = 0;
  Vec3 weights{1.0, 0.0, 0.0};
};
[[nodiscard]] InFan locate(const Fan& fan, const Vec2& centre, const Vec2& point);

/// Smallest angle of a triangle [rad]; negative if it is turned away from `normal`.
[[nodiscard]] double smallest_angle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal);

}  // namespace voile::adapt

// Obstacles of a contact surface, and where they are at a time.
//
// Symbols   X, x(X, t)   place of a material point of an obstacle at rest and at time t                          [m]
// Points of all obstacles but half-spaces are points of a contact surface (surface.hpp), after those of the sheet.
// Theory: docs/theory/contact.md.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "contact_set.hpp"
#include "obstacle.hpp"

namespace voile::contact {

/// The obstacles of a contact surface. Not collective: alike on every rank.
class Obstacles {
 public:
  /// Appends their points and triangles to the surface, which has a body for each, from `first_body` on.
  Obstacles(std::vector<Obstacle> list, int first_body, Surface& surface);

  [[nodiscard]] std::size_t size() const { return list_.size(); }
  [[nodiscard]] const Obstacle& operator[](std::size_t k) const { return list_[k]; }
  [[nodiscard]] int body(std::size_t k) const { return first_body_ + static_cast<int>(k); }
  /// Number of the obstacle that is a body; none for parts of the sheet.
  [[nodiscard]] std::optional<std::size_t> of_body(int body) const;
  [[nodiscard]] bool any_passable() const;
  /// The half-spaces among them, not placed yet.
  [[nodiscard]] std::vector<Plane> planes() const;
  /// Puts points and half-spaces where they are at a time [s].
  void place(double time, std::vector<Vec3>& x, std::vector<Plane>& planes) const;
  /// How far the material point of a body that is at `place` at the time `before` has gone until `now`, for rigid
  /// motions; zero for what stands still and for the sheet; none where points move one by one. [m]
  [[nodiscard]] std::optional<Vec3> displacement(int body, const Vec3& place, double before, double now) const;
  /// Positions of the points of an obstacle among all points; none for a half-space.
  [[nodiscard]] std::vector<Vec3> points(std::size_t k, const std::vector<Vec3>& x) const;
  /// Whether a triangle of the sheet with these corners is `apart` [m] from an obstacle, and not inside it.
  [[nodiscard]] bool is_free(std::size_t k, const std::array<Vec3, 3>& corners, const std::vector<Vec3>& x,
                             const std::vector<Plane>& planes, double apart) const;

 private:
  std::vector<Obstacle> list_;
  int first_body_;
  std::vector<Index> first_point_;  ///< of each; no_index for a half-space
};

}  // namespace voile::contact

// Obstacles: shapes that the sheet can touch, and how they move.
//
// Symbols   X, x(X, t)   place of a material point of an obstacle at rest and at time t                          [m]
// A rigid motion is a displacement X -> x - X that is affine in X at each time; a deforming mesh has frames.
// Theory: docs/theory/contact.md.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::contact {

struct Obstacle {
  enum class Shape { mesh, plane, sphere, capsule };
  std::string name;
  Shape shape = Shape::mesh;
  std::vector<Vec3> points;  ///< mesh: vertices; plane: a point of it; sphere: centre; capsule: ends of its axis [m]
  std::vector<mesh::Triangle> triangles;  ///< mesh only
  Vec3 normal = Vec3::UnitZ();            ///< plane: towards the free side
  double radius = 0.0;                    ///< sphere, capsule [m]
  double thickness = 0.0;                 ///< its surface lies half of this further out [m]
  double friction = 0.0;                  ///< against the sheet
  /// Rigid: displacement of the material point at X at time t; empty: at rest.
  std::function<Vec3(const Vec3& rest, double time)> motion;
  /// Deforming mesh: positions of `points` at time t, instead of `motion`.
  std::function<std::vector<Vec3>(double time)> frames;
  /// Cloth that it pinches passes through it: see system::Contact::clear_predictor.
  bool passable = false;
  int number = 0;  ///< among those of the case, whatever the stage has of them
};

}  // namespace voile::contact

// How long edges may be beside what a sheet comes near: fine enough to go round it before they do.
//
// Symbols   R   radius of curvature of an obstacle [m];  s  distance of its surface from the sheet that touches it [m]
//           d   distance of a vertex from the obstacle's surface, less what the two come nearer until then [m]
//           h = angle (R + s) + d, at least `smallest`: an edge there turns by no more than `angle`
// Round are spheres, capsules, and convex edges of meshes: R is the mean height of the two triangles beside the edge over
// the angle between them, or 0 if that is above 30 degrees. Planes have no curvature.
#pragma once

#include <vector>

#include "adapt/sizing.hpp"
#include "system/contact_scene.hpp"

namespace voile::setup {

/// A part of an obstacle that is round or sharp: what is within `radius` of a segment.
struct Bend {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  ///< [m]
  double radius = 0.0;                          ///< [m]
  double size = 0.0;                            ///< edges wanted at its surface [m]
  double advance = 0.0;                         ///< what it moves in the time that is looked ahead [m]
};

/// The bends of a surface whose edges ask for less than `largest`; of a closed one only convex edges. `apart`: s [m].
[[nodiscard]] std::vector<Bend> bends_of(const std::vector<Vec3>& points, const std::vector<mesh::Triangle>& triangles,
                                         const adapt::SizeOptions& o, double apart);

/// Those of all obstacles where they are; `ahead` [s]: the time in which they may come nearer. Collective: bodies in frames
/// are read by rank 0.
[[nodiscard]] std::vector<Bend> bends_of(const system::ContactScene& scene, const adapt::SizeOptions& o, double ahead);

/// Lowers the bound of every vertex that comes near a bend. `places` [m] and `advance` [m] of vertices, which may be empty:
/// none. Not collective.
void bound_near(const std::vector<Bend>& bends, const std::vector<Vec3>& places, const std::vector<double>& advance,
                double largest, std::vector<double>& bound);

}  // namespace voile::setup

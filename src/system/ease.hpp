// Ease: how far a garment lies from the body in it.
//
// Symbols   e_v   distance of vertex v of the sheet to the nearest surface of an obstacle [m];  A_v   its area [m^2]
//   mean = sum A_v e_v / sum A_v
// Half-spaces are no bodies. Of a ball and a capsule the surface is the true one, of others that of their triangles,
// half of the obstacle's thickness further out. Distances have no sign: what is inside a body counts as if outside.
#pragma once

#include <vector>

#include "contact_scene.hpp"

namespace voile::system {

/// Whether some obstacle is a body. Not collective.
[[nodiscard]] bool has_bodies(const ContactInput& input);

/// Ease of each vertex at state a, obstacles at the time in force; on rank 0, empty elsewhere. At least one obstacle
/// must be a body. Collective. [m]
[[nodiscard]] std::vector<double> ease(const ContactScene& scene, Vec a);

struct EaseRange {
  double least, mean;  ///< [m]
};
/// Over some vertices, all if `vertices` is empty. Not collective.
[[nodiscard]] EaseRange range_of_ease(const ContactScene& scene, const std::vector<double>& ease,
                                      const std::vector<Index>& vertices);

}  // namespace voile::system

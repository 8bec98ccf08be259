// Vertices that lie on a sheet without being a part of its triangles there, where sheets end on each other.
#pragma once

#include "mesh/surface_mesh.hpp"

namespace voile::geometry {

struct HangingVertices {
  Index count = 0;
  Vec3 place = Vec3::Zero();  ///< of one of them [m]
};

/// Whether a vertex can hang on triangles that have a side in common with its own.
enum class Beside { counted, skipped };

/// Vertices on a boundary within `tolerance` [m] of a triangle, and others within it of a boundary edge, that is not theirs and has
/// no corner at their place. `rims`: edges that count as boundary besides. Not collective.
[[nodiscard]] HangingVertices find_hanging(const mesh::MeshData& data, double tolerance,
                                           Beside beside = Beside::counted,
                                           const std::vector<mesh::Segment>& rims = {});

}  // namespace voile::geometry

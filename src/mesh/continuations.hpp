// Which sheets at a joint continue each other: a flange across its web. Private to src/mesh.
//
// Two sheets continue each other where both deviate from one plane through the edge by less than `largest_turn`, and neither
// has a straighter continuation.
#pragma once

#include <map>
#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

struct Continuation {
  Index next;     ///< triangle
  bool opposite;  ///< both run along the edge in opposite directions, as consistent neighbours do
};

/// By triangle, in the order of `next`.
[[nodiscard]] std::map<Index, std::vector<Continuation>> continuations(const MeshData& data,
                                                                       const std::vector<Joint>& joints);

}  // namespace voile::mesh

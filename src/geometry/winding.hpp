// Inside and outside of closed triangle meshes.
#pragma once

#include <vector>

#include "base/types.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::geometry {

/// Whether every directed edge of the triangles has its reverse exactly once, so that inside has a meaning.
[[nodiscard]] bool is_closed(const std::vector<mesh::Triangle>& triangles);

/// How often triangles wind around a point: 1 inside a closed surface with normals outwards, 0 outside, the fraction of
/// the solid angle for an open one. Not collective.
[[nodiscard]] double winding_number(const Vec3& point, const std::vector<Vec3>& x,
                                    const std::vector<mesh::Triangle>& triangles);

}  // namespace voile::geometry

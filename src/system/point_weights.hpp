// What gravity does to point masses.
#pragma once

#include <functional>
#include <vector>

#include "conditions.hpp"
#include "mesh/surface_mesh.hpp"

namespace voile::system {

/// Calls `add` with each vertex that has a mass under a load of gravity, and its weight at load factor 1 [N]. A mass of a group that
/// the load names weighs in full. Of another one that part does which the load's group has of the area around the vertex, so that
/// loads on the parts of a sheet together are one on the whole. Not collective.
void add_point_weights(const mesh::SurfaceMesh& mesh, const Load& load, const std::vector<PointMass>& masses,
                       const std::function<void(Index vertex, const Vec3& force)>& add);

}  // namespace voile::system

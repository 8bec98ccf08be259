// Shared scalar, index and small-matrix types.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace voile {

using Index = std::int32_t;  ///< vertex, triangle and edge numbers (same width as PetscInt here)
using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;

inline constexpr Index no_index = -1;

}  // namespace voile

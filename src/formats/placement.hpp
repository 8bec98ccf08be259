// Where the points of a file go in the scene.
//
// Symbols   x   point of the file, already in metres [m]      x'   its place in the scene [m]
//           U   turns y up into z up: (x, y, z) -> (x, -z, y); identity if z is up in the file
//           R   turns about the fixed axes x, then y, then z        t   translation [m]
//
//   x' = R U x + t
#pragma once

#include <vector>

#include "base/types.hpp"

namespace voile::formats {

struct Placement {
  enum class UpAxis { y, z };
  UpAxis up_axis = UpAxis::z;     ///< of the file
  Vec3 rotate = Vec3::Zero();     ///< angles about x, y and z of the scene, in this order [degree]
  Vec3 translate = Vec3::Zero();  ///< t [m]

  /// Whether points stay exactly where they are.
  [[nodiscard]] bool is_identity() const;
  /// R U. Quarter turns are exact. Not collective.
  [[nodiscard]] Mat3 rotation() const;
  /// Puts points of the file in place. Not collective.
  void apply(std::vector<Vec3>& points) const;
};

}  // namespace voile::formats

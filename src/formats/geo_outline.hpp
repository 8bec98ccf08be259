// Outlines of the surfaces of a Gmsh script (.geo), by the program voile-gmsh.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace voile::formats {

/// A curve of an outline, in the direction in which that goes round.
struct GeoCurve {
  std::string name;               ///< of its physical group; may be empty
  std::string start_name;         ///< of the physical group of its first point; may be empty
  std::vector<Vec3> points;       ///< two: a straight line; more: at equal steps of the parameter [file units]
  std::vector<Vec3> derivatives;  ///< at the points, by steps [file units]
};

struct GeoFace {
  std::string name;  ///< of its physical group, or surface-NUMBER
  std::vector<std::vector<GeoCurve>> loops;
};

/// All surfaces of a script. `parameters`: numbers that it declares by DefineConstant. Not collective: call on one rank. Throws UserError as
/// read_gmsh() does, and for outlines that are not closed.
[[nodiscard]] std::vector<GeoFace> read_geo_faces(const std::string& file,
                                                  const std::map<std::string, double>& parameters,
                                                  bool allow_system_call);

}  // namespace voile::formats

// Supports and loads as the user states them: by group name, in SI units.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "voile/base/types.hpp"

namespace voile::system {

struct Support {
  enum class Kind {
    displacement,  ///< the named components of every vertex of the group follow `value` x load factor
    hinged,        ///< all three components fixed (to `value`), the edge free to rotate
    clamped,       ///< as hinged, and the slope across the group's boundary edges is held
    symmetry       ///< no displacement along `normal`, mirrored slope across the group's boundary edges
  };
  std::string group;  ///< point, curve or surface group; clamped: curve or surface (all of it held); symmetry: curve
  Kind kind = Kind::displacement;
  std::array<bool, 3> components{false, false, false};  ///< displacement only: which of x, y, z
  Vec3 value = Vec3::Zero();                            ///< displacement at load factor 1 [m]
  std::optional<Vec3> normal;                           ///< symmetry: normal of the plane; absent: found from the group
  double release = std::numeric_limits<double>::infinity();  ///< time at which it lets go [s]
  /// Displacement [m] of the vertex with rest position X at time t [s], added to `value`; empty: none.
  std::function<Vec3(const Vec3& rest, double time)> motion;
};

struct Load {
  enum class Kind {
    point,              ///< force on every vertex of the group [N], dead
    line,               ///< force per rest length along a curve group [N/m], dead
    pressure,           ///< dead surface traction along the rest normal [Pa], surface group
    follower_pressure,  ///< pressure along the current normal [Pa], positive along the triangle's normal, surface group
    area,               ///< dead force per rest area [N/m^2], surface group
    gravity,            ///< acceleration [m/s^2] acting on the areal density, whole model or surface group
    follower_moment     ///< moment per rest length about the boundary edge [N], curve group, turns with the shell
  };
  Kind kind = Kind::point;
  std::string group;           ///< empty: the whole surface (gravity, area, pressure kinds)
  Vec3 vector = Vec3::Zero();  ///< point, line, area, gravity, at load factor 1
  double magnitude = 0.0;      ///< pressure, follower_pressure, follower_moment, at load factor 1
  bool constant = false;       ///< true: acts in full at every load factor (e.g. dead weight)
};

}  // namespace voile::system

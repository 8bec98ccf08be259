// The force that a seam carries, from the fabric beside it.
//
// Symbols   T   tension: force per rest length of the seam, positive where it is pulled apart                     [N/m]
//           F, N, nu   deformation gradient of a triangle, its membrane force (second Piola-Kirchhoff) and the outward
//                      normal of its side, in material axes;  m   outward normal of the side in the deformed triangle
//   T = m.(F N nu), from the triangles on both sides: in equilibrium they carry the same, and so do the springs of a
//   seam that is still open; the force of these hangs on micrometres and is lost in the tolerance of a step.
// Source: G.A. Holzapfel, Nonlinear Solid Mechanics (2000), 3.1, 3.2 (tractions).
#pragma once

#include <string>
#include <vector>

#include "energy/sheet.hpp"
#include "recovery.hpp"

namespace voile::system {

struct SeamTension {
  std::string name;
  double length = 0.0;               ///< at rest, mean of both sides [m]
  double mean = 0.0, largest = 0.0;  ///< along the seam [N/m]
};

/// Across the edges of a curve group: one line of a welded seam, or both sides of an open one. `force`:
/// TriangleFields::membrane_force. Not collective.
[[nodiscard]] SeamTension seam_tension(const energy::Sheet& sheet, const mesh::Group& line,
                                       const std::vector<double>& force, const std::vector<Vec3>& places);

}  // namespace voile::system

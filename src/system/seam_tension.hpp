// The force that a seam carries, from the fabric beside it.
//
// Symbols   T   tension: force per rest length of the seam, positive where it is pulled apart                     [N/m]
//           F, N   deformation gradient of a triangle and its membrane force (second Piola-Kirchhoff), A its area at rest
//           m   out of a deformed triangle across a side on the seam, as long as half of that side at rest          [m]
//   At a vertex of the seam the triangles on one side of it pull with  f = sum A F N grad(phi);  T = f.m/m.m with the
//   sum of m over that side. Forces at vertices are what balances: tractions of the triangles at the seam alone do not
//   where an ease makes one row of cells differ from the next. The springs of an open seam carry the same; their force
//   hangs on micrometres and is lost in the tolerance of a step. Where m > 2 layers are welded along one line, half of the
//   sum of their pulls: what the line carries, the same for each seam that it is of.
// Source: O.C. Zienkiewicz, R.L. Taylor, The Finite Element Method, 5th ed. (2000), vol. 1, 2.2 (nodal forces).
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
  /// Of the mean, by the scatter from vertex to vertex [N/m]: beside an eased or gathered seam bending carries part of
  /// the force, the membrane forces of small folds are far larger than the tension, and the mean may be wrong by all of
  /// that, since what one vertex errs by is not independent of the next.
  double error = 0.0;
};

/// Across the edges of a curve group: one line of a welded seam, or both sides of an open one. `force`:
/// TriangleFields::membrane_force. Not collective.
[[nodiscard]] SeamTension seam_tension(const energy::Sheet& sheet, const mesh::Group& line,
                                       const std::vector<double>& force, const std::vector<Vec3>& places);

}  // namespace voile::system

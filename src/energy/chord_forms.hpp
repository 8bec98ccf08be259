// Spurious strain of straight chords in a bent membrane that is uneven or curved, by one curvature per triangle: the
// estimate of chord_error.hpp.
//
// Symbols   E_r      mean strain of the six-node membrane, r = 11, 22, 2 x 12: E_r = 1/2 sum_ij Q^r_ij x_i.x_j - rest
//           k_A      curvature vectors of the triangle, A = 11, 22, 2 x 12 [1/m]
//           l        p_j - p_i, chord between two points of the patch in the plane of the triangle [m]
//           S        1/24 sum over sides of l (x) l, averaged twice from triangles to vertices and back [m^2]
// If the surface bends without stretching, |x_i - x_j|^2 = |l|^2 - |l.k l|^2 / 12, so chords have the spurious strain
//   E_r = -1/2 sum_AB T^r_AB (k_A.k_B - kappa0_A kappa0_B),  T^r = -1/24 sum_{i != j} Q^r_ij lam lam^T,
//   lam = (l1^2, l2^2, l1 l2).
// On even cells it is the same in all triangles, E_ab = -k_ac S_cd k_bd, which flat sheets make up for at next to no energy.
// T^r here is without that part, and zero beside a crease.
// Theory: docs/theory/membrane.md (3).
#pragma once

#include <array>
#include <vector>

#include "sheet.hpp"

namespace voile::energy {

/// T^r of the triangles of a sheet, which must outlive it.
class ChordForms {
 public:
  /// Passes over all triangles. Not collective.
  explicit ChordForms(const Sheet& sheet);
  /// From the Q^r of triangle t [1/m^2]; T^r [m^2].
  [[nodiscard]] std::array<Mat3, 3> of(Index t, const std::array<Eigen::Matrix<double, 6, 6>, 3>& q) const;
  /// R of the trace of k S k = sum_AB R_AB k_A.k_B of triangle t [m^2].
  [[nodiscard]] Mat3 trace(Index t) const;

 private:
  const Sheet* sheet_;
  std::vector<Mat2> even_;  ///< S in the axes of each triangle
};

/// Whether a side of triangle t is a crease.
[[nodiscard]] bool beside_crease(const Sheet& sheet, Index t);

}  // namespace voile::energy

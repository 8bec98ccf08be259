// What a triangle counts too much where a sheet vibrates or buckles: the work of membrane forces on slopes, and its mass.
//
// Symbols   K      curvature of the small displacement w along the normal                                      [1/m]
//           e_k    sides of the triangle; i, j its corners, with area coordinates L_i
//           N      membrane force of the state, N = sum_k n_k e_k (x) e_k                                       [N/m]
// A membrane has the strain 1/2 (e_k.grad w)^2 along its sides, as corrected for the curvature of each. The next parallel side lies
// e_o beyond, and between both the strain is that of a parabola: the trapezoidal rule is too large, and N does too much work by
//   N:D,  e_k.D e_k = min_o (e_k.K e_o)^2 / 12                                   per area (twist in n cells across: by 2/n^2)
// With w = sum L_i w_i - 1/2 sum_(i<j) (e_ij.K e_ij) L_i L_j masses count too much of w^2 by what they make of the corners less the
// mean of its square. Theory: docs/theory/error-estimates.md, modes.
#pragma once

#include <array>

#include "base/types.hpp"

namespace voile::energy {

/// N:D of (N11, N22, N12) and (k11, k22, 2 k12) [J/m^2]. Corners and both in the same axes, in the plane of the triangle [m].
[[nodiscard]] double excess_of_slopes(const std::array<Vec2, 3>& corners, const Vec3& force, const Vec3& curvature);

/// Mean of |u|^2 that masses have, lumped at the corners or consistent with linear displacements, less that of the quadratic [m^2].
/// `displacements` u of the corners [m], `normal` that to which the curvature belongs.
[[nodiscard]] double excess_of_mass(const std::array<Vec2, 3>& corners, const std::array<Vec3, 3>& displacements,
                                    const Vec3& normal, const Vec3& curvature, bool lumped);

}  // namespace voile::energy

// The heart loop: both ends of a strip are clamped together, the strip above the clamp; it bends out and down to both sides.
//
// Symbols   L    length of the strip between the clamps [m];  h  from the clamp down to the lowest point [m]
//           D    bending rigidity along the strip [N m];  w  weight per area [N/m^2];  load  w L^3/D
// Half of the strip, s from its lowest point, theta from the horizontal, in lengths L:
//   theta'' = H sin theta - load s cos theta,  theta(0) = x(0) = 0,  theta(1/2) = 3 pi/2,  x(1/2) = 0,  h/L = z(1/2)
// which is 0.13386 without weight. It is found by chains of links, whose error of second order is extrapolated.
// Peirce's approximation for the bending length c = (D/w)^(1/3):
//   l0 = 0.1337 L,  a = 32.85 deg (h - l0)/l0,  c = l0 (cos a / tan a)^(1/3)
// is off by -1.6 % (c = 0.46 L) to +4 % (c = 0.15 L). Source: F. T. Peirce, J. Textile Inst. 21 (1930) T377-T416.
#pragma once

namespace voile::fit {

inline constexpr double lightest_heart = 0.13387, longest_heart = 0.41;  ///< h/L between which loads are found

/// h/L of a load, which is positive; a power law from 3000 on, where h/L is 0.409.
[[nodiscard]] double heart_height(double load);
/// The load of h/L between the two limits above.
[[nodiscard]] double heart_load(double height);
/// c/L by Peirce's formula; 0 where it has none.
[[nodiscard]] double peirce_length(double height);

}  // namespace voile::fit

// How much of the stored energy the membrane's strains owe to chords: they are measured along straight lines between
// vertices, which are shorter than the bent surface. Theory: docs/theory/error-estimates.md (3).
//
// Symbols   T^r      spurious strain r of chords, without the part of even cells (chord_forms.hpp) [m^2]
//           kappa    curvature of the triangle (k11, k22, 2 k12), kappa0 at rest [1/m]
//   w = 1/2 dE.C dE per area,   dE_r = 1/2 (kappa.T^r kappa - kappa0.T^r kappa0), linear: kappa0.T^r (kappa - kappa0)
// The sum of w over the stored energy estimates the fraction by which deflections of sheets that are flat at rest are too small.
// six_node_corrected: w (kappa L)^2, kappa the largest principal curvature and L^2 as in locking_estimate(): the cubic that corrects
// strains leaves those of the next order, measured on saddles and hemispheres.
// Shells whose rest shape is curved can lock so far that they no longer bend, and w is small: see locking_estimate().
#pragma once

#include <array>
#include <vector>

#include "sheet.hpp"

namespace voile::energy {

class ChordError {
 public:
  /// Of all triangles of the sheet. Not collective.
  explicit ChordError(const Sheet& sheet);

  /// w of each triangle [J/m^2] from curvatures in material axes, three per triangle: the change from rest, and the whole.
  /// `sheet` is that of the constructor. `linear`: of first order in the change, for displacements of no certain size.
  [[nodiscard]] std::vector<double> energies(const Sheet& sheet, const std::vector<double>& curvature,
                                             const std::vector<double>& whole_curvature, bool linear) const;

 private:
  std::vector<std::array<Mat3, 3>> corrections_;
};

/// Fraction by which deflections of a thin curved shell that bends without stretching can be too small: r/(r + 10), r the mean
/// over the area of (kappa0 L^2)^2 / h^2 / 12, with the largest principal curvature at rest, L^2 the mean of the squared
/// sides and h^2 = 12 D/C. Measured on hemispheres and saddles of thickness 4e-3 to 1e-4 of their size, where it is right
/// within a factor of 1.5. 0 for `cst`; for `six_node_corrected` times (kappa0 L)^2 before the mean. `rest_curvature`: three per triangle. Not collective.
[[nodiscard]] double locking_estimate(const Sheet& sheet, const std::vector<double>& rest_curvature);

}  // namespace voile::energy

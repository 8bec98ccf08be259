// Spurious strain of straight chords in a bent membrane, and its removal; and what bending loses when chords are no
// longer longer than they should be.
//
// Symbols   E_r      strain of the six-node membrane or of the triangle alone, r = 11, 22, 2 x 12:
//                    E_r = 1/2 sum_ij Q^r_ij x_i.x_j - rest
//           K_B      how the surface bends across the patch, seven vectors (patch_cubic.hpp); the first three are the second
//                    derivatives at the centroid; their normal parts at rest are kappa0_B
//           k_c      sum_B s_cB K_B, bend along chord c from p_i to p_j times its squared length, at its middle [m]
// If the surface bends without stretching, |x_i - x_j|^2 = |p_i - p_j|^2 - |k_c|^2 / 12 to the sixth order in the chord, so that
//   E_r + 1/2 sum_c W_rc (|k_c|^2 - |k_c at rest|^2),   W_rc = -Q^r_ij / 12
// is free of it. Zero beside a crease. Theory: docs/theory/membrane.md (4).
// Second differences of an arc by the angle t per cell are too small by the factor 1 - t^2/12 once its length is right (by half of
// that if its chords have the length of the arc, as in the uncorrected membrane). So the energy has the term
//   A (q_D - q_D at rest) (q_S - q_S at rest),   q_D = sum_AB D_AB K_A.K_B,   q_S = sum_AB R_AB K_A.K_B = trace of k S k
// with S the mean of the squared sides of the cells around (chord_forms.hpp): it is of fourth order in the curvature.
// The kernels (membrane_lanes.hpp) take all of it in the axes y of the cubic, in which s follows from the places of two points.
#pragma once

#include <array>
#include <vector>

#include "patch_cubic.hpp"
#include "sheet.hpp"

namespace voile::energy {

/// What the membrane element of a triangle is given besides.
struct ChordCorrection {
  static constexpr int most = 64;    ///< points
  std::vector<Index> stencil;        ///< the six nodes of the membrane, then the other points of the cubic
  std::vector<double> numbers;       ///< from membrane_fields::chord on
  std::array<Vec3, 2> start_strain;  ///< of the correction, to be added to the mean strain and the triangle's own
  std::array<Vec3, 2> whole_strain;  ///< the same counted from a flat patch
  bool left_out = false;             ///< too many points: not corrected
  bool fourth = false;               ///< has the term of fourth order
  /// Of that term: A D and R in the axes of the triangle, the first three of K at rest, and A q_D and q_S at the start.
  Mat3 in_plane = Mat3::Zero(), trace = Mat3::Zero();
  Vec3 rest_bend = Vec3::Zero();
  std::array<double, 2> start_squares{};
};

/// A triangle and what its correction is made from; points in one numbering of the caller's.
struct ChordInput {
  using Forms = std::array<Eigen::Matrix<double, 6, 6>, 3>;
  const Sheet& sheet;
  Index triangle;
  const BendingElement& bending;
  const std::vector<Index>& local;       ///< points of `bending`
  const std::array<Index, 6>& six;       ///< the membrane's nodes
  const std::array<Forms, 2> quadratic;  ///< Q^r of the two strains
  Mat3 trace;                            ///< R; zero: no term of fourth order
};
/// A chord of the patch of a triangle: its bend k_c = start + sum_i weights_i u_i, in mesh numbering, and W_rc.
struct BentChord {
  std::vector<Index> points;
  std::vector<double> weights;
  Vec3 start, fraction;
};
/// Those that a strain with the forms Q^r is corrected for. None beside a crease.
[[nodiscard]] std::vector<BentChord> bent_chords(const Sheet& sheet, Index t, const BendingElement& bending,
                                                 const ChordInput::Forms& quadratic);

/// A triangle with more than `most` points is left uncorrected: one whose cubic is that of a bending element of so many.
[[nodiscard]] ChordCorrection make_chord_correction(const ChordInput& input);

}  // namespace voile::energy

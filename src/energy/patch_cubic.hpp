// How the surface bends across the patch of a triangle: a cubic x(p) in the plane of the triangle, fitted to the twelve points of
// its patch and of its neighbours' patches.
//
// Symbols   p, c     place in the plane, centroid of the triangle [m];  y = W (p - c), W takes the points' spread to that of a
//                    unit circle, so that stretched cells are as good as others
//           K        seven vectors: the second derivatives at c, (x,11 ; x,22 ; 2 x,12) [1/m], and the coefficients of
//                    y1^3, y1^2 y2, y1 y2^2, y2^3 [m], each sum_i B'_i x_i
//           l        a chord;  its bend l.k l, k the second derivatives at its middle, is sum_B s_B K_B
// Least squares with the third derivatives held back by `restraint`: where points are few or on top of each other the fit
// leans to the quadratic, which it reproduces exactly. Two chords that lie in two patches bend there as one as far as the cubic goes:
// curvatures that are constant in each triangle would not agree.
// Theory: docs/theory/membrane.md, the correction.
#pragma once

#include <array>
#include <vector>

#include "bending.hpp"
#include "sheet.hpp"

namespace voile::energy {

/// Vectors of the basis, and one number for each.
constexpr int bend_vectors = 7;
using BendWeights = Eigen::Matrix<double, bend_vectors, 1>;
using Bends = Eigen::Matrix<double, 3, bend_vectors>;

struct PatchCubic {
  std::vector<Index> points;  ///< some of the bending element's, in mesh numbering; may repeat
  std::vector<BendWeights>
      weights;  ///< B'_i: without the spurious part of in-plane derivatives at rest, see bending.hpp
  BendWeights rest = BendWeights::Zero();  ///< N.K at rest
  Bends start = Bends::Zero();             ///< K at the start, column B
  Mat2 spread = Mat2::Identity();          ///< W [1/m]
  Vec2 centre = Vec2::Zero();              ///< c

  /// s of a chord from a to b.
  [[nodiscard]] BendWeights along(const Vec2& a, const Vec2& b) const;
};

/// Uses no points beyond those of `bending`, the element of triangle t. Where they do not determine a quadratic, as at corners, the
/// curvature of the bending element alone.
[[nodiscard]] PatchCubic make_patch_cubic(const Sheet& sheet, Index t, const BendingElement& bending);

}  // namespace voile::energy

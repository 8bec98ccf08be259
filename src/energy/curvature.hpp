// The constant curvature operator of a triangle: kappa = (x,11 ; x,22 ; 2 x,12) = sum_i B_i x_i, vector valued.
//
// Symbols   q_T        quadratic through the six points of the unfolded patch of T
//           n, t       outward normal and tangent of a side in the plane of T;  l its length;  A area of T
//           m_e        middle of side e
//           tau_e      (x_b - x_a)/l, exact derivative along the side
//           phi_e      derivative along n at m_e, one value per edge shared (with opposite sign) by its two triangles
// six_node (the Sze-Zhou operator, Int. J. Numer. Meth. Engng 89 (2012) 509-536):   kappa_T = second derivatives of q_T
// edge_slope (Morley's energy with its slopes reconstructed):
//   phi_e   = 1/2 [ grad q_T+(m_e).n - grad q_T-(m_e).n' ]
//   kappa_T = 1/A sum_e l_e sym( (tau_e t + phi_e n) (x) n )
// phi_e is exact for quadratics and sum_T A_T M:kappa_T telescopes to the boundary, so the constant-curvature patch
// test passes on every mesh. Free edge: phi_e minimises the bending energy, i.e. M_nn = 0. Mirrored edge: phi_e from
// the mirror point. Where a patch is incomplete or ill conditioned (six points near a conic) phi_e comes from the other
// side, and where both are, from a weighted least-squares quadratic over rings of vertices.
// Seams whose bending differs by a factor f (BendingSide):  B = B_cut + sqrt(f) (B - B_cut), B_cut that of the sheet cut
// along them. Where nothing else bends, M_nn = 0 makes the two parts of kappa orthogonal in D, and the energy is
// f times that across the seam: f = 0 is a hinge, f = 1 the fabric as it is. Triangles further away take the factor of
// the seam next to them, else the smallest. Theory: docs/theory/curvature.md (2), edge-slopes.md.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sheet.hpp"

namespace voile::energy {

/// B of one triangle over mesh points (vertices and mirror points), points ascending. Units of weights: 1/m^2.
/// Row r of `rest` is k_r of the rest shape, in the chart of the triangle [1/m]. It is found where the weights are, since
/// a vertex on a seam has several rest positions.
struct CurvatureOperator {
  std::vector<Index> points;
  Eigen::Matrix<double, 3, Eigen::Dynamic> weights;
  Mat3 rest = Mat3::Zero();
};

/// P of triangle t: of a curvature kappa its operator finds P kappa, the rest is up to the slopes of free sides, which minimise the
/// energy. Identity where there are none. (I - P) D^-1 is symmetric.
[[nodiscard]] Mat3 free_side_projector(const Sheet& sheet, Index t);

/// Builds operators triangle by triangle, caching patch fits. Local to a rank; keeps a reference to the sheet.
class CurvatureBuilder {
 public:
  explicit CurvatureBuilder(const Sheet& sheet);
  ~CurvatureBuilder();
  /// The operator of triangle t in its material axes, without any correction for a curved rest shape.
  [[nodiscard]] CurvatureOperator build(Index t);
  /// That of edge_slope before its free sides follow.
  struct Unreleased {
    CurvatureOperator operator_;
    std::vector<int> sides;    ///< that are free
    std::vector<Vec3> across;  ///< what a slope of each adds to the curvature [1/m]
  };
  [[nodiscard]] Unreleased build_unreleased(Index t);
  /// Condition number of the scaled six-point fit of t; infinite if singular.
  [[nodiscard]] double patch_condition(Index t);

 private:
  struct Impl;
  struct Cut;
  std::unique_ptr<Impl> impl_;
  std::unique_ptr<Cut> cut_;  ///< null: no seam bends otherwise
};

}  // namespace voile::energy

// Slopes of the free sides of a triangle, before they follow (curvature.hpp). Symbols: joint.hpp.
// Theory: docs/theory/edge-slopes.md, free edges.
#pragma once

#include <Eigen/Dense>
#include <algorithm>

#include "curvature.hpp"

namespace voile::energy {

struct FreeSlopes {
  CurvatureBuilder::Unreleased of;
  Eigen::Matrix<double, 3, Eigen::Dynamic> across;  ///< S
  Eigen::MatrixXd compliance;                       ///< C_T^-1
  Eigen::MatrixX3d natural;                         ///< C_T^-1 A S^T D

  FreeSlopes(const Sheet& sheet, CurvatureBuilder& curvatures, Index t) : of(curvatures.build_unreleased(t)) {
    across.resize(3, static_cast<Eigen::Index>(of.across.size()));
    for (std::size_t k = 0; k < of.across.size(); ++k) across.col(static_cast<Eigen::Index>(k)) = of.across[k];
    const Eigen::MatrixX3d moment = sheet.mesh().area(t) * across.transpose() * sheet.material(t).bending;
    compliance = (moment * across).inverse();
    natural = compliance * moment;
  }
  /// Row of side s.
  [[nodiscard]] Eigen::Index row(int s) const {
    return std::find(of.sides.begin(), of.sides.end(), s) - of.sides.begin();
  }
};

}  // namespace voile::energy

// A moment on a free edge, by the slope that the edge has (curvature.hpp).
//
// Symbols   phi_s   slope of side s: derivative of the positions along its outward normal, = w.x + C_T^-1 e_s m l where moments m
//                   act per length l; w as a free edge has it;  C_T, S (joint.hpp)
//   The moment turns w.x (loads.hpp) and adds S C_T^-1 e_s m l to the curvature of the triangle, so that M_nn = m on the edge.
#pragma once

#include <optional>
#include <vector>

#include "curvature.hpp"

namespace voile::energy {

struct EdgeMoment {
  std::vector<Index> points;    ///< mesh points; the ends of the side and the corner across first
  std::vector<double> weights;  ///< w [1/m]; their sum is zero
  Vec3 bend;                    ///< S C_T^-1 e_s [1/(N m^2)], in material axes
};

/// On side s of triangle t. None if the bending operator knows no slopes or the slope is not free. Not collective.
[[nodiscard]] std::optional<EdgeMoment> make_edge_moment(const Sheet& sheet, CurvatureBuilder& curvatures, Index t,
                                                         int s);

}  // namespace voile::energy

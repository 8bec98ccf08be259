// Closest points of two simple figures, and the derivatives of their distance.
//
// Symbols   x_i     vertices of the pair, at most four                                              [m]
//           c_i     signed weights: w = sum_i c_i x_i joins the closest points, d = |w|, n = w/d
//           s_k     the free parameters of the closest points (none, one or two), c_i,k = dc_i/ds_k
//           t_k     = dw/ds_k = sum_i c_i,k x_i;  w.t_k = 0;  A_kl = t_k.t_l
// As d^2 is a minimum over s, its derivatives with respect to the vertices are those of a reduced function:
//   d(d^2/2)/dx_i = c_i w,     d2(d^2/2) = c c^T (x) I - G A^-1 G^T,     G_ik = c_i,k w + c_i t_k
// Everything happens in five dimensions: the vertices move along n in the span of c, c_,1, c_,2, and along the two
// tangents in the direction c only. In that orthonormal basis the second derivative is a 5 x 5 matrix.
// Source: minimum of a parametric quadratic; closest points as in Ericson, Real-Time Collision Detection, chapter 5.
#pragma once

#include <array>

#include "base/types.hpp"

namespace voile::contact {

using Mat5 = Eigen::Matrix<double, 5, 5>;
using Vec4 = Eigen::Vector4d;

struct Closest {
  Vec4 c = Vec4::Zero();
  std::array<Vec4, 2> dc{Vec4::Zero(), Vec4::Zero()};
  int free = 0;           ///< how many of dc are used
  Vec3 w = Vec3::Zero();  ///< [m]
  double distance = 0.0;  ///< [m]
};

/// Point x[0] and triangle x[1..3], which may be degenerate.
[[nodiscard]] Closest point_triangle(const std::array<Vec3, 4>& x);
/// Point x[0] and segment x[1], x[2]; x[3] is ignored.
[[nodiscard]] Closest point_edge(const std::array<Vec3, 4>& x);
/// Segments x[0], x[1] and x[2], x[3], which may be parallel or points.
[[nodiscard]] Closest edge_edge(const std::array<Vec3, 4>& x);

/// The distances alone, of the same pairs: several times cheaper than their closest points. [m]
[[nodiscard]] double point_triangle_distance(const std::array<Vec3, 4>& x);
[[nodiscard]] double point_edge_distance(const std::array<Vec3, 4>& x);
[[nodiscard]] double edge_edge_distance(const std::array<Vec3, 4>& x);

/// The basis of the five motions that change the distance: motion k moves vertex i by frame[k] weight[k][i].
struct Motions {
  std::array<Vec3, 5> frame;
  std::array<Vec4, 5> weight;
};

/// d2(d)/dx2 in the basis of `motions`. Requires d > 0. The gradient is |c| along motion 0.
[[nodiscard]] Mat5 distance_hessian(const std::array<Vec3, 4>& x, const Closest& closest, Motions& motions);

}  // namespace voile::contact

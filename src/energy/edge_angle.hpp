// The angle of two triangles at their common edge, with its derivatives.
//
// Symbols   a, b      ends of the edge, e = b - a, l = |e|
//           p, q      points across it, of the triangles (a, b, p) and (b, a, q);  P = p - a, Q = q - a
//           n_p, n_q  normals e x P and Q x e, on the same side of the sheet
//           theta     angle between them in (-pi, pi], positive where q lies on the side of n_p
//           f_p       e.P / l^2, foot of the altitude of p
//   dtheta/dp = l n_p / |n_p|^2,  dtheta/dq = l n_q / |n_q|^2,  dtheta/db = -f_p dtheta/dp - f_q dtheta/dq
// and dtheta/da such that their sum is zero. Source: Tamstorf & Grinspun, Graphical Models 75 (2013) 362-370.
#pragma once

#include <array>

#include "base/types.hpp"

namespace voile::energy {

/// a, b, p, q. [m]
using EdgePoints = std::array<Vec3, 4>;

/// theta; 0 where a triangle has no area, where its derivatives are not numbers.
[[nodiscard]] double edge_angle(const EdgePoints& x);
/// Its derivatives by the four points [1/m].
[[nodiscard]] EdgePoints edge_angle_slopes(const EdgePoints& x);
/// Its second derivatives [1/m^2].
using EdgeAngleCurvature = std::array<std::array<Mat3, 4>, 4>;
[[nodiscard]] EdgeAngleCurvature edge_angle_curvature(const EdgePoints& x);

}  // namespace voile::energy

// Barrier potential of a gap, and the mollifier of edges that become parallel. Theory: docs/theory/contact.md (1).
//
// Symbols   g     gap: distance of two mid-surfaces less their offset                       [m]
//           dh    activation distance: where the barrier begins                                [m]
//   b(g) = -dh (g/dh - 1)^2 ln(g/dh)   for 0 < g < dh, infinite below, zero above           [m]
// Times a stiffness kappa [Pa] and an area [m^2] it is an energy; kappa |b'| is a pressure (1.19 kappa at g = dh/2).
//   m(x) = (2 - x/e) x/e for x < e, else 1;   x = |a x b|^2 of two edges, e = 1e-3 of the product of their rest lengths
//   squared. The direction that joins parallel edges jumps; there the points of each against the other's triangles act.
// Source: Li et al., Incremental Potential Contact, ACM TOG 39 (2020); physical units: Li et al., Convergent IPC, 2023.
#pragma once

#include <cmath>
#include <limits>

#include "distance.hpp"

namespace voile::contact {

struct Scalar2 {
  double value = 0.0, first = 0.0, second = 0.0;  ///< a function of one variable and its derivatives
};

[[nodiscard]] inline Scalar2 barrier(double g, double dh) {
  if (g >= dh) return {};
  if (!(g > 0.0)) return {std::numeric_limits<double>::infinity(), 0.0, 0.0};
  const double y = g / dh, l = std::log(y), z = y - 1.0;
  return {-dh * z * z * l, -(2.0 * z * l + z * z / y), -(2.0 * l + 4.0 * z / y - z * z / (y * y)) / dh};
}

[[nodiscard]] inline Scalar2 mollifier(double x, double e) {
  if (x >= e) return {1.0, 0.0, 0.0};
  return {(2.0 - x / e) * x / e, 2.0 * (1.0 - x / e) / e, -2.0 / (e * e)};
}

[[nodiscard]] inline double mollifier_threshold(double rest_a_squared, double rest_b_squared) {
  return 1e-3 * rest_a_squared * rest_b_squared;
}

using Vec12 = Eigen::Matrix<double, 12, 1>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

/// |a x b|^2 of edges x[0]x[1] and x[2]x[3]; derivatives by vertex if asked for.
double cross_squared(const std::array<Vec3, 4>& x, Vec12* gradient = nullptr, Mat12* hessian = nullptr);

}  // namespace voile::contact

#include "failure.hpp"

#include <algorithm>
#include <cmath>

namespace voile::energy {

namespace {

double of_sign(double x, double tensile, double compressive) {
  return x >= 0.0 ? x / tensile : -x / compressive;
}

double maximum_stress(const Strength& s, const Vec3& x) {
  return std::max({of_sign(x[0], s.tensile_1, s.compressive_1), of_sign(x[1], s.tensile_2, s.compressive_2),
                   std::abs(x[2]) / s.shear});
}

/// The moduli cancel: E1 e1 = s1 - nu12 s2, E2 e2 = s2 - nu21 s1, G12 e12 = t.
double maximum_strain(const Strength& s, const Vec3& x) {
  const double poisson_21 = s.poisson_12 * s.young_2 / s.young_1;
  return maximum_stress(s, {x[0] - s.poisson_12 * x[1], x[1] - poisson_21 * x[0], x[2]});
}

double tsai_wu(const Strength& s, const Vec3& x) {
  const double f11 = 1.0 / (s.tensile_1 * s.compressive_1), f22 = 1.0 / (s.tensile_2 * s.compressive_2);
  const double a =
      f11 * x[0] * x[0] + f22 * x[1] * x[1] + x[2] * x[2] / (s.shear * s.shear) - std::sqrt(f11 * f22) * x[0] * x[1];
  const double b =
      x[0] * (1.0 / s.tensile_1 - 1.0 / s.compressive_1) + x[1] * (1.0 / s.tensile_2 - 1.0 / s.compressive_2);
  return 0.5 * (b + std::sqrt(b * b + 4.0 * a));  // 1/R solves y^2 - b y - a = 0
}

double hashin(const Strength& s, const Vec3& x) {
  const double fibre = of_sign(x[0], s.tensile_1, s.compressive_1), shear = x[2] / s.shear,
               matrix = of_sign(x[1], s.tensile_2, s.compressive_2);
  return std::max(std::hypot(fibre, x[0] >= 0.0 ? shear : 0.0), std::hypot(matrix, shear));
}

}  // namespace

double failure_index(const Strength& strength, const Vec3& stress) {
  using Criterion = Strength::Criterion;
  switch (strength.criterion) {
    case Criterion::hashin:
      return hashin(strength, stress);
    case Criterion::maximum_stress:
      return maximum_stress(strength, stress);
    case Criterion::maximum_strain:
      return maximum_strain(strength, stress);
    case Criterion::tsai_wu:
      break;
  }
  return tsai_wu(strength, stress);
}

Vec3 turned_stress(const Vec3& s, double angle) {
  const double c = std::cos(angle), n = std::sin(angle);
  return {c * c * s[0] + n * n * s[1] + 2.0 * c * n * s[2], n * n * s[0] + c * c * s[1] - 2.0 * c * n * s[2],
          c * n * (s[1] - s[0]) + (c * c - n * n) * s[2]};
}

}  // namespace voile::energy

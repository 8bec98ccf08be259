// What a triangle counts too much: against sums over cells, and means of quadratics by quadrature.
#include "energy/slope_error.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace test_slope_error {

using namespace voile;

namespace {

using Corners = std::array<Vec2, 3>;

Vec3 voigt(const Mat2& m, double shear) {
  return {m(0, 0), m(1, 1), shear * m(0, 1)};
}

/// Mean over a triangle of f, exact for polynomials of degree 4 (Dunavant 1985).
template <class F>
double mean(const Corners& x, F&& f) {
  double sum = 0.0;
  for (const auto& [a, w] :
       {std::pair{0.445948490915965, 0.223381589678011}, std::pair{0.091576213509771, 0.109951743655322}})
    for (std::size_t k = 0; k < 3; ++k) sum += w * f(a * (x[0] + x[1] + x[2]) + (1.0 - 3.0 * a) * x[k]);
  return sum;
}

}  // namespace

TEST_CASE("tension does too much work on a twist by twice the square of one over the cells across") {
  const double width = 0.3, length = 0.1, twist = 0.7;
  const Mat2 curvature = (Mat2() << 0.0, twist, twist, 0.0).finished(), force = Vec2(5.0, 0.0).asDiagonal();
  for (const int cells : {1, 2, 4}) {
    const double h = width / cells;
    // The mean of N (y twist)^2 / 2 over the width, where y is taken at the sides.
    const double exact = 5.0 * twist * twist * width * width / 24.0;
    for (const double turn : {0.0, 0.4, 2.0}) {
      const Mat2 r = Eigen::Rotation2Dd(turn).toRotationMatrix();
      const Corners lower{Vec2(0, 0), r * Vec2(length, 0), r * Vec2(0, h)},
          upper{r * Vec2(length, h), r * Vec2(0, h), r * Vec2(length, 0)};
      for (const Corners& x : {lower, upper})
        CHECK(energy::excess_of_slopes(x, voigt(r * force * r.transpose(), 1.0),
                                       voigt(r * curvature * r.transpose(), 2.0)) /
                  exact ==
              doctest::Approx(2.0 / (cells * cells)));
    }
  }
}

TEST_CASE("bending along and across the sides is none too much") {
  const Corners x{Vec2(0, 0), Vec2(0.1, 0), Vec2(0, 0.2)};
  CHECK(energy::excess_of_slopes(x, {5.0, 7.0, 0.0}, {0.4, -3.0, 0.0}) == doctest::Approx(0.0));
}

TEST_CASE("masses are compared with the mean square of a quadratic") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Vec3 normal = Vec3(1, -2, 2) / 3.0;
  for (int n = 0; n < 10; ++n) {
    Corners x{Vec2(0, 0), Vec2(1.0 + 0.3 * any(random), 0.3 * any(random)),
              Vec2(0.3 * any(random), 1.0 + 0.3 * any(random))};
    Mat2 k;
    k << any(random), 0.0, 0.0, any(random);
    k(0, 1) = k(1, 0) = any(random);
    const Vec2 slope(any(random), any(random));
    const auto w = [&](const Vec2& p) { return 0.3 + slope.dot(p) + 0.5 * p.dot(k * p); };
    const Vec3 drift = Vec3(2, 2, 1) / 3.0;  // in the plane: no quadratic, and the same everywhere
    std::array<Vec3, 3> u;
    for (std::size_t i = 0; i < 3; ++i) u[i] = w(x[i]) * normal + drift;
    const double exact = 1.0 + mean(x, [&](const Vec2& p) { return w(p) * w(p); });
    const double lumped = (u[0].squaredNorm() + u[1].squaredNorm() + u[2].squaredNorm()) / 3.0;
    const double linear = ((u[0] + u[1] + u[2]).squaredNorm() + 3.0 * lumped) / 12.0;
    CHECK(energy::excess_of_mass(x, u, normal, voigt(k, 2.0), true) == doctest::Approx(lumped - exact));
    CHECK(energy::excess_of_mass(x, u, normal, voigt(k, 2.0), false) == doctest::Approx(linear - exact));
  }
}

}  // namespace test_slope_error

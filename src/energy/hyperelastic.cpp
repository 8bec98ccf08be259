#include "hyperelastic.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace voile::energy {

namespace {

/// w as a function of the squared stretches a = l1^2, b = l2^2, with first and second derivatives.
struct Principal {
  double w = 0.0, a = 0.0, b = 0.0, aa = 0.0, ab = 0.0, bb = 0.0;
  /// mu/alpha (a^p + b^p + (a b)^-p - 3), p = alpha/2.
  void add(double factor, double p, double x, double y) {
    const double u = std::pow(x, p), v = std::pow(y, p), inverse = 1.0 / (u * v);
    w += factor * (u + v + inverse - 3.0);
    a += factor * p * (u - inverse) / x;
    b += factor * p * (v - inverse) / y;
    aa += factor * p * ((p - 1.0) * u + (p + 1.0) * inverse) / (x * x);
    bb += factor * p * ((p - 1.0) * v + (p + 1.0) * inverse) / (y * y);
    ab += factor * p * p * inverse / (x * y);
  }
};

Mat2 tensor_of(const Vec3& strain) {
  Mat2 c;
  c << 1.0 + 2.0 * strain[0], strain[2], strain[2], 1.0 + 2.0 * strain[1];
  return c;
}

/// Squared stretches and the direction of the first, of C; ascending.
struct Axes {
  double a, b;
  Vec2 first;
  [[nodiscard]] bool possible() const { return a > 0.0 && std::isfinite(b); }
};
Axes axes_of(const Vec3& strain) {
  Eigen::SelfAdjointEigenSolver<Mat2> solver;
  solver.computeDirect(tensor_of(strain));
  return {solver.eigenvalues()[0], solver.eigenvalues()[1], solver.eigenvectors().col(0)};
}

Principal principal_response(const Hyperelastic& law, const Axes& axes) {
  Principal p;
  if (law.c10 != 0.0) p.add(law.c10, 1.0, axes.a, axes.b);
  if (law.c01 != 0.0) p.add(law.c01, -1.0, axes.a, axes.b);
  for (const Hyperelastic::Term& t : law.terms) p.add(t.modulus / t.exponent, 0.5 * t.exponent, axes.a, axes.b);
  return p;
}

/// (w_a - w_b)/(a - b), which is w_aa - w_ab where both are the same.
double shear_slope(const Principal& p, const Axes& axes) {
  return axes.b - axes.a > 1e-5 * axes.b ? (p.b - p.a) / (axes.b - axes.a) : 0.5 * (p.aa + p.bb) - p.ab;
}

/// n (x) n as a form on strains (11, 22, 2 12).
Vec3 form_of(const Vec2& n, const Vec2& m) {
  return {n[0] * m[0], n[1] * m[1], 0.5 * (n[0] * m[1] + n[1] * m[0])};
}

}  // namespace

double Hyperelastic::shear_modulus() const {
  double sum = 2.0 * (c10 + c01);
  for (const Term& t : terms) sum += 0.5 * t.modulus * t.exponent;
  return sum;
}

void Hyperelastic::scale(double factor) {
  c10 *= factor;
  c01 *= factor;
  for (Term& t : terms) t.modulus *= factor;
}

HyperelasticResponse response(const Hyperelastic& law, const Vec3& strain) {
  const Axes axes = axes_of(law.natural * strain);
  HyperelasticResponse r;
  if (!axes.possible()) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, Vec3::Constant(nan), Mat3::Constant(nan), false};
  }
  const Principal p = principal_response(law, axes);
  const Vec2 n = axes.first, m(-n[1], n[0]);
  const Vec3 along = form_of(n, n), across = form_of(m, m), shear = form_of(n, m);
  // dC = 2 dE
  r.energy = law.area * p.w;
  r.force = law.area * law.natural.transpose() * (2.0 * (p.a * along + p.b * across));
  const Mat3 tangent = 4.0 * (p.aa * along * along.transpose() + p.bb * across * across.transpose() +
                              p.ab * (along * across.transpose() + across * along.transpose())) +
                       8.0 * shear_slope(p, axes) * shear * shear.transpose();
  r.tangent = law.area * law.natural.transpose() * tangent * law.natural;
  return r;
}

Stretches stretches_of(const Vec3& strain) {
  const Axes axes = axes_of(strain);
  return {std::sqrt(std::max(axes.b, 0.0)), std::sqrt(std::max(axes.a, 0.0))};
}

double thinning(const Hyperelastic& law, const Vec3& strain) {
  return 1.0 / std::sqrt(tensor_of(law.natural * strain).determinant());
}

Vec3 true_force(const Hyperelastic& law, const Vec3& strain) {
  const Axes axes = axes_of(law.natural * strain);
  if (!axes.possible()) return Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  const Principal p = principal_response(law, axes);
  const Vec2 n = axes.first, m(-n[1], n[0]);
  return 2.0 * (axes.a * p.a * form_of(n, n) + axes.b * p.b * form_of(m, m));
}

double ellipticity(const Hyperelastic& law, const Vec3& strain) {
  const Axes axes = axes_of(law.natural * strain);
  if (!axes.possible()) return -1.0;
  const Principal p = principal_response(law, axes);
  // A wave with amplitude q and direction k, both in principal axes of C at rest: dF = q k^T, F diagonal.
  const Vec2 stretch(std::sqrt(axes.a), std::sqrt(axes.b));
  const double shear = 2.0 * shear_slope(p, axes);
  constexpr int directions = 36;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < directions; ++i) {
    const double angle = std::numbers::pi * i / directions;
    const Vec2 k(std::cos(angle), std::sin(angle));
    // dE = sym(F^T q k^T): dC/2 = (s1 q1 k1, s2 q2 k2, (s1 q1 k2 + s2 q2 k1)/2)
    Mat2 acoustic = 2.0 * (p.a * k[0] * k[0] + p.b * k[1] * k[1]) * Mat2::Identity();
    const Vec2 e1(stretch[0] * k[0], 0.0), e2(0.0, stretch[1] * k[1]), e3(stretch[0] * k[1], stretch[1] * k[0]);
    acoustic += 4.0 * (p.aa * e1 * e1.transpose() + p.bb * e2 * e2.transpose() +
                       p.ab * (e1 * e2.transpose() + e2 * e1.transpose())) +
                shear * e3 * e3.transpose();
    Eigen::SelfAdjointEigenSolver<Mat2> solver;
    solver.computeDirect(acoustic, Eigen::EigenvaluesOnly);
    least = std::min(least, solver.eigenvalues()[0]);
  }
  return least / law.shear_modulus();
}

}  // namespace voile::energy

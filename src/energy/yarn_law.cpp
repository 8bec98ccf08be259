#include "yarn_law.hpp"

#include <algorithm>
#include <cmath>

#include "material.hpp"

namespace voile::energy {

namespace {

/// Knots of a tangent that is linear between these strains, and what it is at the first.
YarnCurve curve_of(const std::vector<YarnPoint>& tangents) {
  YarnCurve c{tangents.front().force};
  double slope = 0.0;
  const auto turn = [&](double strain, double next, bool is_end = false) {
    if (next != slope || is_end) c.knots.push_back({strain, next - slope});
    slope = next;
  };
  for (std::size_t i = 0; i + 1 < tangents.size(); ++i)
    turn(tangents[i].strain,
         (tangents[i + 1].force - tangents[i].force) / (tangents[i + 1].strain - tangents[i].strain));
  turn(tangents.back().strain, 0.0, true);
  return c;
}

/// 2 (1/a - 1/(exp(a) - 1)): area below exp(a x) - 1 up to x = 1 by that of the triangle.
double linearity(double a) {
  return a < 1e-3 ? 1.0 - a / 6.0 : 2.0 * (1.0 / a - 1.0 / std::expm1(a));
}

}  // namespace

YarnCurve yarn_curve(std::vector<YarnPoint> points) {
  points.insert(points.begin(), YarnPoint{0.0, 0.0});
  const std::size_t last = points.size() - 1;
  std::vector<double> slope;
  for (std::size_t i = 0; i < last; ++i)
    slope.push_back((points[i + 1].force - points[i].force) / (points[i + 1].strain - points[i].strain));
  std::vector<double> at(last + 1);
  for (std::size_t i = 1; i < last; ++i) at[i] = 2.0 * slope[i - 1] * slope[i] / (slope[i - 1] + slope[i]);
  at[0] = last > 1 ? 0.5 * (3.0 * slope[0] - at[1]) : slope[0];
  at[last] = last > 1 ? 0.5 * (3.0 * slope[last - 1] - at[last - 1]) : slope[0];
  std::vector<YarnPoint> tangents{{0.0, at[0]}};
  for (std::size_t i = 0; i < last; ++i) {
    tangents.push_back({0.5 * (points[i].strain + points[i + 1].strain), 2.0 * slope[i] - 0.5 * (at[i] + at[i + 1])});
    tangents.push_back({points[i + 1].strain, at[i + 1]});
  }
  return curve_of(tangents);
}

Interval tangents_of(const YarnPoint& end, double area) {
  const double secant = end.force / end.strain, lt = 2.0 * area / (end.force * end.strain);
  return {std::max(0.0, (3.0 * lt - 2.0) * secant), lt * secant};
}

YarnCurve yarn_curve(const YarnPoint& end, double area, double tangent) {
  const double secant = end.force / end.strain, lt = 2.0 * area / (end.force * end.strain);
  if (tangent <= 0.0) {
    double low = 0.0, high = 1.0;
    while (linearity(high) > lt) high *= 2.0;
    for (int k = 0; k < 100; ++k) (linearity(0.5 * (low + high)) > lt ? low : high) = 0.5 * (low + high);
    tangent = low > 0.0 ? secant * low / std::expm1(low) : secant;
  }
  const double width = 3.0 * (area - 0.5 * tangent * end.strain * end.strain) / (end.force - tangent * end.strain);
  const double most = tangent + 2.0 * (end.force - tangent * end.strain) / width;
  return curve_of({{0.0, tangent}, {end.strain - width, tangent}, {end.strain, most}});
}

double force_of(const YarnCurve& curve, double strain) {
  double force = curve.tangent * strain;
  for (const YarnLaw::Knot& k : curve.knots) force += 0.5 * k.bend * std::pow(std::max(strain - k.strain, 0.0), 2);
  return force;
}

bool is_stable(const Mat3& membrane, const YarnLaw& law) {
  if (law.rubs() && law.rise >= law.stiffness) return false;
  Mat3 least = membrane;
  for (int r = 0; r < 3; ++r) {
    double change = 0.0, lowest = 0.0, bend = 0.0, at = 0.0;
    for (const YarnLaw::Knot& k : law.knots[static_cast<std::size_t>(r)]) {
      change += bend * (k.strain - at);
      lowest = std::min(lowest, change);
      bend += k.bend;
      at = k.strain;
    }
    if (bend < -1e-9 * membrane(r, r)) return false;
    least(r, r) += lowest;
  }
  if (law.rubs()) least(2, 2) -= law.stiffness * law.rise / (law.stiffness - law.rise);
  return is_positive_definite(least);
}

Mat3 yarn_axes(const YarnLaw& law) {
  return turned_strain(law.warp_angle) * law.natural;
}

Vec3 added_force(const YarnLaw& law, const Vec3& strain) {
  const Mat3 turn = yarn_axes(law);
  const Vec3 e = turn * strain;
  Vec3 force;
  for (int r = 0; r < 3; ++r) {
    const double size = force_of({0.0, law.knots[static_cast<std::size_t>(r)]}, r < 2 ? e[r] : std::abs(e[r]));
    force[r] = r < 2 ? size : std::copysign(size, e[r]);
  }
  return law.area * turn.transpose() * force;
}

Mat3 added_tangent(const YarnLaw& law, const Vec3& strain) {
  const Mat3 turn = yarn_axes(law);
  const Vec3 e = turn * strain;
  Vec3 tangent = Vec3::Zero();
  for (int r = 0; r < 3; ++r)
    for (const YarnLaw::Knot& k : law.knots[static_cast<std::size_t>(r)])
      tangent[r] += k.bend * std::max(0.0, (r < 2 ? e[r] : std::abs(e[r])) - k.strain);
  return law.area * turn.transpose() * tangent.asDiagonal() * turn;
}

}  // namespace voile::energy

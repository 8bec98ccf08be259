#include "instruments.hpp"

#include <cmath>
#include <utility>

#include "energy/material.hpp"
#include "heart_loop.hpp"
#include "input/fabric.hpp"
#include "input/units.hpp"
#include "voile/errors.hpp"

namespace voile::fit {

namespace {

using P = Parameter;

constexpr double secant_force = 14.71, bias_force = 1.23;  // [N/m], docs/reference/fabrics.md

constexpr std::array<ParameterName, parameter_count> names{
    {{"areal_density", "g/m^2", 1e-3},        {"thickness", "mm", 1e-3},
     {"bending_warp", "uN.m", 1e-6},          {"bending_weft", "uN.m", 1e-6},
     {"bending_twist", "uN.m", 1e-6},         {"bending_hysteresis", "mN", 1e-3},
     {"bending_hysteresis_weft", "mN", 1e-3}, {"bending_hysteresis_spread", "1/m", 1.0},
     {"membrane_warp", "N/m", 1.0},           {"membrane_weft", "N/m", 1.0},
     {"membrane_shear", "N/m", 1.0},          {"shear_hysteresis", "N/m", 1.0},
     {"shear_hysteresis_5", "N/m", 1.0},      {"shear_hysteresis_spread", "deg", std::numbers::pi / 180.0},
     {"tension_warp EMT", "%", 1e-2},         {"tension_weft EMT", "%", 1e-2},
     {"tension_warp WT", "J/m^2", 1.0},       {"tension_weft WT", "J/m^2", 1.0},
     {"overhang.angle", "deg", degree},       {"heart_loop.length", "mm", 1e-3}}};

double rigidity_along(const Values& v, Direction d, double strip) {
  if (d == Direction::warp) return at(v, P::bending_warp);
  if (d == Direction::weft) return at(v, P::bending_weft);
  const BiasLimits limits = bias_limits(at(v, P::bending_warp), at(v, P::bending_weft), at(v, P::bending_twist));
  return limits.narrow + strip * (limits.cylinder - limits.narrow);
}

double green(double extension) {
  return extension + 0.5 * extension * extension;
}

/// Horizontal and vertical reach of a heavy elastica with this angle at its tip, and its load number.
struct Elastica {
  double along = 0.0, down = 0.0, load = 0.0;
};
/// From the tip: theta'' = -t cos theta, in lengths (D/w)^(1/3), until theta is zero at the clamp. Fourth order of Runge and Kutta.
Elastica elastica(double tip) {
  struct Point {
    double theta, slope, along, down;
  };
  const auto rate = [](double t, const Point& p) {
    return Point{p.slope, -t * std::cos(p.theta), std::cos(p.theta), std::sin(p.theta)};
  };
  const auto moved = [](const Point& p, const Point& r, double h) {
    return Point{p.theta + h * r.theta, p.slope + h * r.slope, p.along + h * r.along, p.down + h * r.down};
  };
  constexpr double step = 2e-3;
  Point p{tip, 0.0, 0.0, 0.0};
  double t = 0.0;
  for (;;) {
    const auto advanced = [&](double h) {
      const Point a = rate(t, p), b = rate(t + 0.5 * h, moved(p, a, 0.5 * h)),
                  c = rate(t + 0.5 * h, moved(p, b, 0.5 * h)), d = rate(t + h, moved(p, c, h));
      return moved(moved(moved(moved(p, a, h / 6.0), b, h / 3.0), c, h / 3.0), d, h / 6.0);
    };
    const Point next = advanced(step);
    if (next.theta > 0.0) {
      p = next;
      t += step;
      continue;
    }
    double h = step * p.theta / (p.theta - next.theta);
    for (int i = 0; i < 4; ++i) h -= advanced(h).theta / advanced(h).slope;
    p = advanced(h);
    return {p.along, p.down, std::pow(t + h, 3)};
  }
}

}  // namespace

const ParameterName& name_of(Parameter p) {
  return names[static_cast<std::size_t>(p)];
}

Values ordinary_values() {
  return {0.2, 5e-4, 1e-5,         1e-5, 5e-6, 3e-4, 3e-4, input::typical_spread, 2e3, 2e3, 50.0,
          1.0, 3.0,  0.5 * degree, 0.05, 0.05, 8.0,  8.0,  41.5 * degree,         0.2};
}

double cantilever_load(double angle) {
  double low = 0.0, high = 0.5 * std::numbers::pi;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const Elastica e = elastica(middle);
    (std::atan2(e.down, e.along) < angle ? low : high) = middle;
  }
  return elastica(low).load;
}

double linear_extension(double stiffness, double load) {
  double x = load / stiffness / (1.0 + load / stiffness);  // below the root of a convex function
  for (int i = 0; i < 50; ++i)
    x -= (stiffness * green(x) * (1.0 + x) - load) / (stiffness * (1.0 + 3.0 * x + 1.5 * x * x));
  return x;
}

double Instrument::read(const Values& v) const {
  const bool warp = direction == Direction::warp;
  const double stiffness = at(v, warp ? P::membrane_warp : P::membrane_weft),
               x = linear ? linear_extension(stiffness, load) : at(v, warp ? P::extension_warp : P::extension_weft),
               area = linear ? 0.5 * stiffness * green(x) * green(x) : at(v, warp ? P::work_warp : P::work_weft);
  switch (kind) {
    case Kind::figure:
      return at(v, parameter);
    case Kind::bending_length:
      return std::cbrt(rigidity_along(v, direction, strip) / input::bending_rigidity(at(v, P::areal_density), 1.0));
    case Kind::overhang: {
      // One angle for all strips of a sheet.
      static thread_local std::pair<double, double> known{-1.0, 0.0};
      const double fall = angle > 0.0 ? angle : at(v, P::overhang_angle);
      if (known.first != fall) known = {fall, cantilever_load(fall)};
      return std::cbrt(known.second * rigidity_along(v, direction, strip) / (gravity * at(v, P::areal_density)));
    }
    case Kind::heart_loop: {
      const double whole = length > 0.0 ? length : at(v, P::loop_length);
      return whole *
             heart_height(gravity * at(v, P::areal_density) * std::pow(whole, 3) / rigidity_along(v, direction, strip));
    }
    case Kind::rigidity:
      return rigidity_along(v, direction, strip);
    case Kind::extension:
      return x;
    case Kind::work:
      return area;
    case Kind::linearity:
      return 2.0 * area / (load * x);
    case Kind::secant:
      return secant_force / stiffness;
    case Kind::bias_extension:
      return bias_force / at(v, P::membrane_shear);
  }
  throw InternalError("an instrument without a reading");
}

std::vector<double> Loop::forces(const std::vector<double>& strain, bool turned) const {
  std::vector<double> all;
  double slip = 0.0;
  if (turned && strain.size() > 1 && stiffness > 0.0) {
    const double sign = strain[1] < strain[0] ? 1.0 : -1.0;
    slip = (stiffness * strain[0] - sign * limit) / (stiffness + (sign * strain[0] > 0.0 ? rise : -rise));
  }
  for (const double e : strain) {
    const double trial = stiffness * (e - slip);
    if (std::abs(trial) > limit + rise * std::abs(slip)) {
      const double sign = trial > 0.0 ? 1.0 : -1.0, numerator = stiffness * e - sign * limit;
      slip = numerator / (stiffness + (sign * numerator > 0.0 ? rise : -rise));
    }
    all.push_back(elastic * e + stiffness * (e - slip));
  }
  return all;
}

Loop bending_loop(double rigidity, double width, double spread) {
  const std::vector<energy::YarnFriction::Slider> sliders = energy::sliders_of(Vec3::Constant(width), spread, 1);
  if (sliders.empty()) return {rigidity, 0.0, 0.0, 0.0};  // a width that is rounded to zero
  return {rigidity, sliders.front().stiffness[0], sliders.front().limit[0], 0.0};
}

Loop shear_loop(double rigidity, double width, double width_5, double spread) {
  input::Fabric fabric;
  fabric.membrane_warp = fabric.membrane_weft = 1.0;
  fabric.membrane_shear = rigidity;
  fabric.shear_hysteresis = width;
  fabric.shear_hysteresis_5 = width_5;
  fabric.shear_hysteresis_spread = spread;
  const energy::YarnLaw law = input::yarn_law(fabric, true);
  return {input::membrane_stiffness(fabric, true)(2, 2), law.stiffness, law.limit, law.rise};
}

}  // namespace voile::fit

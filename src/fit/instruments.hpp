// Instruments of a textile laboratory as closed forms: what they read off a fabric with these figures.
//
// Symbols   W    areal density [kg/m^2];  w = W g;  D11 D22 D66  bending rigidities [N m];  A11 A22 A66 membrane stiffness [N/m]
//   bending length  c = (D/(9.81 W))^(1/3)                                             FAST-2, ASTM D1388
//   overhang        l = (Gamma D/w)^(1/3), Gamma(a) of the heavy elastica whose chord falls by the angle a; 8.0043 at 41.5 degrees
//   heart loop      heart_loop.hpp
//   bias            D45 = (D11 + D22)/4 + D66        (D12 = 0), of a strip that bends to a cylinder; a narrow one, which twists
//                   where warp and weft are unlike, has 4/(1/D11 + 1/D22 + 1/D66), the inverse of its compliance
//   tension         A (x + x^2/2)(1 + x) = F,  WT = A (x + x^2/2)^2/2,  LT = 2 WT/(F x)  where the law is linear
//   FAST-1          E20 - E5 = 14.71 N/m / A;   FAST-3  EB5 = 1.23 N/m / A66, as FAST has it, without clamps and the stretch of yarns
//   loops           bending: D k, shear: A66 e, plus the slider of energy/yarn_friction.hpp and energy/yarn_law.hpp
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "input/units.hpp"

namespace voile::fit {

inline constexpr double gravity = 9.80665;  // [m/s^2]
using input::degree;

/// Figures of a fabric, all positive, in SI.
enum class Parameter {
  areal_density,
  thickness,
  bending_warp,
  bending_weft,
  bending_twist,
  bending_hysteresis,
  bending_hysteresis_weft,
  bending_hysteresis_spread,
  membrane_warp,
  membrane_weft,
  membrane_shear,
  shear_hysteresis,
  shear_hysteresis_5,
  shear_hysteresis_spread,
  extension_warp,  ///< EMT of a curve
  extension_weft,
  work_warp,  ///< WT of a curve
  work_weft,
  overhang_angle,  ///< of the instrument, from here on: measured too, no figure of the fabric
  loop_length
};
inline constexpr std::size_t parameter_count = 20;
[[nodiscard]] inline bool is_of_fabric(Parameter p) {
  return p < Parameter::overhang_angle;
}
using Values = std::array<double, parameter_count>;

[[nodiscard]] inline double& at(Values& v, Parameter p) {
  return v[static_cast<std::size_t>(p)];
}
[[nodiscard]] inline double at(const Values& v, Parameter p) {
  return v[static_cast<std::size_t>(p)];
}

/// Key of a fabric file, its unit there and the size of that unit in SI.
struct ParameterName {
  const char* key;
  const char* unit;
  double si;
};
[[nodiscard]] const ParameterName& name_of(Parameter p);
/// Ordinary figures, to begin with.
[[nodiscard]] Values ordinary_values();

enum class Kind {
  figure,  ///< a parameter itself
  bending_length,
  overhang,
  heart_loop,  ///< height
  rigidity,    ///< along the bias
  extension,
  work,
  linearity,
  secant,         ///< E20 - E5
  bias_extension  ///< EB5
};
enum class Direction { none, warp, weft, bias };

/// What is read off, and under which conditions.
struct Instrument {
  Kind kind = Kind::figure;
  Parameter parameter = Parameter::areal_density;  ///< of Kind::figure
  Direction direction = Direction::none;
  double angle = 0.0;   ///< of an overhang [rad]; 0: that of the parameter
  double load = 0.0;    ///< of tension [N/m]
  bool linear = false;  ///< tension by A instead of the curve through EMT and WT
  double width = 0.05;  ///< of a cantilever along the bias [m]
  double strip = 1.0;   ///< along the bias: part of the way from BiasLimits::narrow to cylinder
  double length = 0.0;  ///< of the strip of a heart loop [m]; 0: that of the parameter

  [[nodiscard]] double read(const Values& v) const;
};

/// Rigidities along the bias between which a strip is. [N m]
struct BiasLimits {
  double narrow = 0.0, cylinder = 0.0;
};
inline BiasLimits bias_limits(double warp, double weft, double twist) {
  return {4.0 / (1.0 / warp + 1.0 / weft + 1.0 / twist), 0.25 * (warp + weft) + twist};
}

/// w l^3/D of a strip clamped level whose chord falls by `angle` [rad], between 0 and 1.5.
[[nodiscard]] double cantilever_load(double angle);
/// Extension of a linear law under a force per width [N/m].
[[nodiscard]] double linear_extension(double stiffness, double load);

/// A spring and a slider: force on a course of strains.
struct Loop {
  double elastic = 0.0;            ///< beside the slider
  double stiffness = 0.0;          ///< of the spring before it
  double limit = 0.0, rise = 0.0;  ///< of the slider, and by slip
  /// From an unstrained start, or `turned`: from where the strain before grew towards that of the start.
  [[nodiscard]] std::vector<double> forces(const std::vector<double>& strain, bool turned) const;
};
/// Of a bending rigidity B, a width 2HB and the spread of curvature.
[[nodiscard]] Loop bending_loop(double rigidity, double width, double spread);
/// Of G, 2HG, 2HG5 and the spread of the angle, as a fabric file's figures make it: strain is the sine of the angle, and force that
/// over its cosine.
[[nodiscard]] Loop shear_loop(double rigidity, double width, double width_5, double spread);

}  // namespace voile::fit

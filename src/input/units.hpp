// Figures with a unit, as textile laboratories print them: "0.077 gf.cm^2/cm".
#pragma once

#include <numbers>
#include <string>
#include <vector>

namespace voile::input {

constexpr double degree = std::numbers::pi / 180.0;  ///< [rad]

/// What a figure measures.
enum class Dimension {
  length,              ///< m
  mass_per_area,       ///< kg/m^2
  force_per_length,    ///< N/m
  shear_rigidity,      ///< N/m per radian; KES gives it per degree
  bending_rigidity,    ///< N m: moment per width over curvature
  moment_per_width,    ///< N: moment over width
  curvature,           ///< 1/m
  extension,           ///< a ratio
  angle,               ///< rad
  energy_per_area,     ///< J/m^2
  fast_bending_length  ///< m: FAST's measure of bending rigidity, see bending_rigidity()
};

struct Quantity {
  double value = 0.0;  ///< in SI units
  Dimension dimension = Dimension::length;
};

/// Reads a number and the name of a unit. Blanks, points and * in a unit are the same, ^ and
/// brackets may be left out.
/// Throws UserError without a place: no number, no unit, or an unknown unit with the nearest known one.
[[nodiscard]] Quantity parse_quantity(const std::string& text);

/// E.g. "a bending rigidity".
[[nodiscard]] std::string name_of(Dimension dimension);

/// Names of the units of one dimension.
[[nodiscard]] std::vector<std::string> units_of(Dimension dimension);

/// B = 9.81 W c^3 [N m] from the areal density W [kg/m^2] and FAST's bending length c [m]; as FAST has it,
/// B [uN m] = 9.81e-6 W [g/m^2] c^3 [mm^3].
[[nodiscard]] double bending_rigidity(double areal_density, double bending_length);

}  // namespace voile::input

// Units of length that texts may name.
#pragma once

#include <array>
#include <string_view>

namespace voile {

struct LengthUnit {
  const char* name;
  double metres;
};

inline constexpr double inch = 0.0254;  ///< [m]
/// The first is SI's.
inline constexpr std::array length_units{
    LengthUnit{"m", 1.0},   LengthUnit{"cm", 1e-2},        LengthUnit{"mm", 1e-3},       LengthUnit{"um", 1e-6},
    LengthUnit{"in", inch}, LengthUnit{"ft", 12.0 * inch}, LengthUnit{"yd", 36.0 * inch}};

/// Of a unit by its name; 0: there is none of that name.
[[nodiscard]] constexpr double metres_of(std::string_view name) {
  for (const LengthUnit& unit : length_units)
    if (name == unit.name) return unit.metres;
  return 0.0;
}

/// The unit of this many metres; "" if it has no name.
[[nodiscard]] constexpr const char* name_of_metres(double metres) {
  for (const LengthUnit& unit : length_units)
    if (metres == unit.metres) return unit.name;
  return "";
}

}  // namespace voile

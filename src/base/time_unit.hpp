// Units of time that a case may be in.
#pragma once

#include <array>
#include <string_view>

namespace voile {

struct TimeUnit {
  const char* name;
  double seconds;
};

/// The first is SI's.
inline constexpr std::array time_units{TimeUnit{"s", 1.0}, TimeUnit{"ms", 1e-3}, TimeUnit{"min", 60.0}};

/// Of a unit by its name; that of SI if there is none of that name.
[[nodiscard]] constexpr const TimeUnit& time_unit_of(std::string_view name) {
  for (const TimeUnit& unit : time_units)
    if (name == unit.name) return unit;
  return time_units.front();
}

}  // namespace voile

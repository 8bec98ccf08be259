// Columns of frequencies name their unit: "frequency_hz", and "frequency_per_ms" where times are in milliseconds.
#pragma once

#include <string>

namespace voile {

inline constexpr const char* frequency_per = "frequency_per_";

/// `time`: name of the unit of time.
[[nodiscard]] inline std::string frequency_column(const std::string& time) {
  return time == "s" ? "frequency_hz" : frequency_per + time;
}

/// "Hz", "1/ms"; empty for a column of something else.
[[nodiscard]] inline std::string frequency_unit(const std::string& column) {
  if (column == "frequency_hz") return "Hz";
  const std::string start = frequency_per;
  return column.starts_with(start) ? "1/" + column.substr(start.size()) : "";
}

}  // namespace voile

// Loads and wind as read, and expressions of the time; private to src/input.
#pragma once

#include <functional>
#include <string>

#include "case_read.hpp"

namespace voile::input {

/// An expression of the time. What it throws, now and later, names the key.
[[nodiscard]] std::function<double(double)> time_function(const SectionPlace& place, const char* key,
                                                          const std::string& text);
/// Checks a load and makes its functions from their texts. Throws UserError.
void read_load(const SectionPlace& place, const Case& c, system::Load& load);
/// The same of [air].
void read_wind(const SectionPlace& place, const Case& c, energy::DragOptions& air);
/// Whether a load is a gas.
[[nodiscard]] bool has_gas(const Case& c);

}  // namespace voile::input

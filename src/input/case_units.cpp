#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/text.hpp"
#include "case_keys.hpp"
#include "units.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

struct Unit {
  const char* name;
  double si;
  Dimension dimension;
};

constexpr double gram_force = 9.80665e-3;  // [N]
constexpr double ounce = 28.349523125e-3;  // [kg]
constexpr double yard = 0.9144;            // [m]

const std::vector<Unit>& units() {
  static const std::vector<Unit> all{
      {"m", 1.0, Dimension::length},
      {"mm", 1e-3, Dimension::length},
      {"um", 1e-6, Dimension::length},
      {"kg/m^2", 1.0, Dimension::mass_per_area},
      {"g/m^2", 1e-3, Dimension::mass_per_area},
      {"mg/cm^2", 1e-2, Dimension::mass_per_area},
      {"oz/yd^2", ounce / (yard * yard), Dimension::mass_per_area},
      {"N/m", 1.0, Dimension::force_per_length},
      {"kN/m", 1e3, Dimension::force_per_length},
      {"gf/cm", gram_force / 1e-2, Dimension::force_per_length},
      {"gf/(cm.deg)", gram_force / 1e-2 / degree, Dimension::shear_rigidity},
      {"N.m", 1.0, Dimension::bending_rigidity},
      {"uN.m", 1e-6, Dimension::bending_rigidity},
      {"gf.cm^2/cm", gram_force * 1e-2, Dimension::bending_rigidity},
      {"N", 1.0, Dimension::moment_per_width},
      {"mN", 1e-3, Dimension::moment_per_width},
      {"gf.cm/cm", gram_force, Dimension::moment_per_width},
      {"1/m", 1.0, Dimension::curvature},
      {"1/cm", 1e2, Dimension::curvature},
      {"%", 1e-2, Dimension::extension},
      {"rad", 1.0, Dimension::angle},
      {"deg", degree, Dimension::angle},
      {"J/m^2", 1.0, Dimension::energy_per_area},
      {"gf.cm/cm^2", gram_force / 1e-2, Dimension::energy_per_area},
      {"mm FAST", 1e-3, Dimension::fast_bending_length},
  };
  return all;
}

/// A unit in one spelling: blanks and signs of multiplication between letters become a point; ^ and brackets go.
std::string plain(std::string unit) {
  const std::vector<std::pair<std::string, std::string>> same{{"\u00b7", "."}, {"\u00b2", "2"},   {"\u00b5", "u"},
                                                              {"\u03bc", "u"}, {"degree", "deg"}, {"/deg", ".deg"},
                                                              {"Nm", "N.m"}};
  std::erase_if(unit, [](char c) { return c == '^' || c == '(' || c == ')'; });
  for (const auto& [from, to] : same)
    for (std::size_t at = unit.find(from); at != std::string::npos; at = unit.find(from))
      unit.replace(at, from.size(), to);
  std::string out;
  bool apart = false;
  for (const char c : unit) {
    if (c == ' ' || c == '.' || c == '*') {
      apart = true;
      continue;
    }
    if (apart && !out.empty() && out.back() != '/' && c != '/') out += '.';
    apart = false;
    out += c;
  }
  return out;
}

}  // namespace

std::string name_of(Dimension dimension) {
  switch (dimension) {
    case Dimension::length:
      return "a length";
    case Dimension::mass_per_area:
      return "a mass per area";
    case Dimension::force_per_length:
      return "a force per length";
    case Dimension::shear_rigidity:
      return "a shear rigidity per angle";
    case Dimension::bending_rigidity:
      return "a bending rigidity";
    case Dimension::moment_per_width:
      return "a moment per width";
    case Dimension::curvature:
      return "a curvature";
    case Dimension::extension:
      return "an extension";
    case Dimension::angle:
      return "an angle";
    case Dimension::energy_per_area:
      return "an energy per area";
    case Dimension::fast_bending_length:
      return "a bending length of FAST";
  }
  return "";
}

std::vector<std::string> units_of(Dimension dimension) {
  std::vector<std::string> names;
  for (const Unit& unit : units())
    if (unit.dimension == dimension) names.emplace_back(unit.name);
  return names;
}

Quantity parse_quantity(const std::string& text) {
  const std::size_t begin = std::min(text.find_first_not_of(' '), text.size());
  double number = 0.0;
  const auto [end, problem] = std::from_chars(text.data() + begin, text.data() + text.size(), number);
  if (problem != std::errc() || !std::isfinite(number))
    throw UserError(fmt::format("'{}': a number and a unit are needed, e.g. \"0.077 gf.cm^2/cm\"", text));
  const std::size_t unit_begin = text.find_first_not_of(' ', static_cast<std::size_t>(end - text.data()));
  if (unit_begin == std::string::npos)
    throw UserError(fmt::format("'{}': the unit is missing; add it, or write an SI number without quotes", text));
  const std::string unit = text.substr(unit_begin);
  std::vector<std::string> names;
  for (const Unit& known : units()) {
    if (plain(known.name) == plain(unit)) return {number * known.si, known.dimension};
    names.emplace_back(known.name);
  }
  throw UserError(fmt::format("'{}': unknown unit '{}':{}", text, unit, suggestion(unit, names)));
}

double bending_rigidity(double areal_density, double bending_length) {
  return 9.81 * areal_density * bending_length * bending_length * bending_length;
}

}  // namespace voile::input

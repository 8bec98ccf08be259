#include "sheet_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::fit {

namespace {

using input::Dimension;

Instrument of(Parameter p) {
  return {Kind::figure, p};
}
Instrument of(Kind kind, Direction direction) {
  return {kind, Parameter::areal_density, direction};
}
std::vector<std::pair<std::string, Instrument>> both(Kind kind) {
  return {{"warp", of(kind, Direction::warp)}, {"weft", of(kind, Direction::weft)}};
}
std::vector<std::pair<std::string, Instrument>> with_bias(Kind kind) {
  auto parts = both(kind);
  parts.emplace_back("bias", of(kind, Direction::bias));
  return parts;
}

std::vector<Column> declared() {
  using enum Dimension;
  using P = Parameter;
  const std::vector<Dimension> length_of_fast{length, fast_bending_length};
  return {
      {"", "areal_density", {mass_per_area}, "", {{"", of(P::areal_density)}}},
      {"", "thickness", {length}, "", {{"", of(P::thickness)}}},
      {"", "bending_length", length_of_fast, "", with_bias(Kind::bending_length)},
      {"", "overhang", {length}, "", with_bias(Kind::overhang)},
      {"", "heart_loop", {length}, "", both(Kind::heart_loop)},
      {"",
       "bending_rigidity",
       {bending_rigidity},
       "",
       {{"warp", of(P::bending_warp)},
        {"weft", of(P::bending_weft)},
        {"bias", of(Kind::rigidity, Direction::bias)},
        {"twist", of(P::bending_twist)}}},
      {"",
       "membrane_stiffness",
       {force_per_length, shear_rigidity},
       "",
       {{"warp", of(P::membrane_warp)}, {"weft", of(P::membrane_weft)}, {"shear", of(P::membrane_shear)}}},
      {"kes", "W", {mass_per_area}, "mg/cm^2", {{"", of(P::areal_density)}}},
      {"kes", "T", {length}, "mm", {{"", of(P::thickness)}}},
      {"kes", "B", {bending_rigidity}, "gf.cm^2/cm", {{"warp", of(P::bending_warp)}, {"weft", of(P::bending_weft)}}},
      {"kes",
       "2HB",
       {moment_per_width},
       "gf.cm/cm",
       {{"warp", of(P::bending_hysteresis)}, {"weft", of(P::bending_hysteresis_weft)}}},
      {"kes", "G", {shear_rigidity, force_per_length}, "gf/(cm.deg)", {{"", of(P::membrane_shear)}}},
      {"kes", "2HG", {force_per_length}, "gf/cm", {{"", of(P::shear_hysteresis)}}},
      {"kes", "2HG5", {force_per_length}, "gf/cm", {{"", of(P::shear_hysteresis_5)}}},
      {"kes", "EMT", {extension}, "%", both(Kind::extension)},
      {"kes", "WT", {energy_per_area}, "gf.cm/cm^2", both(Kind::work)},
      {"kes", "LT", {}, "", both(Kind::linearity)},
      {"fast", "W", {mass_per_area}, "g/m^2", {{"", of(P::areal_density)}}},
      {"fast", "T2", {length}, "mm", {{"", of(P::thickness)}}},
      {"fast", "C-1", length_of_fast, "mm", {{"", of(Kind::bending_length, Direction::warp)}}},
      {"fast", "C-2", length_of_fast, "mm", {{"", of(Kind::bending_length, Direction::weft)}}},
      {"fast", "B-1", {bending_rigidity}, "uN.m", {{"", of(P::bending_warp)}}},
      {"fast", "B-2", {bending_rigidity}, "uN.m", {{"", of(P::bending_weft)}}},
      {"fast", "E5-1", {extension}, "%", {{"", of(Kind::extension, Direction::warp)}}},
      {"fast", "E5-2", {extension}, "%", {{"", of(Kind::extension, Direction::weft)}}},
      {"fast", "E20-1", {extension}, "%", {{"", of(Kind::extension, Direction::warp)}}},
      {"fast", "E20-2", {extension}, "%", {{"", of(Kind::extension, Direction::weft)}}},
      {"fast", "E100-1", {extension}, "%", {{"", of(Kind::extension, Direction::warp)}}},
      {"fast", "E100-2", {extension}, "%", {{"", of(Kind::extension, Direction::weft)}}},
      {"fast", "EB5", {extension}, "%", {{"", of(Kind::bias_extension, Direction::bias)}}},
      {"fast", "G", {force_per_length}, "N/m", {{"", of(P::membrane_shear)}}},
  };
}

std::string valid_units(const std::vector<Dimension>& dimensions) {
  std::vector<std::string> all;
  for (const Dimension d : dimensions)
    for (const std::string& unit : input::units_of(d)) all.push_back(unit);
  return join(all, ", ");
}

/// One specimen, and its uncertainty if it has one.
struct Reading {
  double value = 0.0, deviation = 0.0;
};

std::string trimmed(const std::string& text) {
  const std::size_t from = std::min(text.find_first_not_of(' '), text.size());
  return text.substr(from, text.find_last_not_of(' ') + 1 - from);
}

Reading read_text(const std::vector<Dimension>& dimensions, const std::string& text) {
  const auto is_plain = [](const std::string& t) {
    return t.find_first_not_of("0123456789.+-eE ") == std::string::npos;
  };
  const auto quantity = [&](const std::string& t) {
    if (is_plain(t))
      throw UserError(
          fmt::format("the unit of '{}' is missing; write it behind the number: {}", t, valid_units(dimensions)));
    const input::Quantity q = input::parse_quantity(t);
    if (!contains(dimensions, q.dimension))
      throw UserError(fmt::format("'{}' is {}, {} is needed: {}", t, input::name_of(q.dimension),
                                  input::name_of(dimensions.front()), valid_units(dimensions)));
    return q.value;
  };
  for (const std::string sign : {"+-", "\u00b1"})
    if (const std::size_t at = text.find(sign); at != std::string::npos) {
      const std::string behind = text.substr(at + sign.size());
      const std::size_t number = std::min(behind.find_first_not_of(' '), behind.size()),
                        unit = std::min(behind.find_first_not_of("0123456789.eE+-", number), behind.size());
      const std::string before = trimmed(text.substr(0, at)), of_it = trimmed(behind.substr(unit));
      const bool percent = of_it == "%";
      Reading r;
      r.value = quantity(is_plain(before) && !percent ? before + ' ' + of_it : before);
      r.deviation = percent ? 0.01 * std::strtod(behind.c_str(), nullptr) * r.value : quantity(behind);
      if (!(r.deviation > 0.0)) throw UserError(fmt::format("'{}': the uncertainty has to be greater than zero", text));
      return r;
    }
  return {quantity(text), 0.0};
}

Reading read_item(const Sheet& sheet, const std::string& key, const std::vector<Dimension>& dimensions,
                  const std::string& unit, const toml::node& node) {
  const int line = line_of(node);
  if (!node.is_number() && !(node.is_string() && !dimensions.empty()))
    sheet.fail(line, key, dimensions.empty() ? "a number is needed" : "a text with a number and a unit is needed");
  if (node.is_number() && !dimensions.empty() && unit.empty())
    sheet.fail(line, key,
               fmt::format("the unit of {:g} is missing; write a text with one of {}", *node.value<double>(),
                           valid_units(dimensions)));
  Reading r;
  try {
    if (node.is_string()) r = read_text(dimensions, *node.value<std::string>());
  } catch (const UserError& e) {
    sheet.fail(line, key, e.what());
  }
  if (node.is_number())
    r.value = *node.value<double>() * (dimensions.empty() ? 1.0 : input::parse_quantity("1 " + unit).value);
  if (!(r.value > 0.0) || !std::isfinite(r.value))
    sheet.fail(line, key,
               fmt::format("{:g} has to be finite and greater than zero; correct it, or leave the figure out",
                           node.is_number() ? *node.value<double>() : r.value));
  if (key.starts_with("kes.LT") && r.value >= 2.0) sheet.fail(line, key, "a number between 0 and 2 is needed");
  return r;
}

/// How much wider than by the normal distribution 95 % lie by Student's with so many degrees of freedom.
double student(int freedom) {
  // t at 97.5 % over 1.96; from 6 on by its expansion (M. Abramowitz & I. Stegun, 26.7.5), less than 1 % off.
  constexpr std::array few{6.483, 2.195, 1.624, 1.417, 1.312};
  if (freedom <= static_cast<int>(few.size())) return few[static_cast<std::size_t>(freedom) - 1];
  const double z = 1.96, n = freedom;
  return 1.0 + (z * z + 1.0) / (4.0 * n) + (5.0 * std::pow(z, 4) + 16.0 * z * z + 3.0) / (96.0 * n * n);
}

/// Mean and its uncertainty from what the specimens spread: twice that holds 95 %, however few they are.
Figure summary_of(const std::vector<Reading>& readings) {
  Figure f;
  f.count = static_cast<int>(readings.size());
  double squares = 0.0;
  for (const Reading& r : readings) f.mean += r.value / f.count;
  for (const Reading& r : readings) squares += std::pow(r.value - f.mean, 2);
  f.deviation =
      f.count > 1 ? student(f.count - 1) * std::sqrt(squares / (f.count - 1.0) / f.count) : readings.front().deviation;
  f.assumed = f.deviation == 0.0 && f.count == 1;
  f.deviation = f.assumed ? assumed_deviation * f.mean : std::max(f.deviation, least_deviation * f.mean);
  return f;
}

void add(Sheet& sheet, const Column& column, const std::string& part, const Instrument& instrument,
         const Figure& figure, int line) {
  Measurement m;
  m.name = (column.section.empty() ? "" : column.section + ".") + column.key + (part.empty() ? "" : "." + part);
  m.line = line;
  m.instrument = instrument;
  m.unit = column.unit;
  if (m.unit.empty() && !column.dimensions.empty()) {
    using enum Dimension;
    const Dimension d = column.dimensions.front();
    m.unit = d == mass_per_area ? "g/m^2" : d == length ? "mm" : d == bending_rigidity ? "uN.m" : "N/m";
  }
  m.si = m.unit.empty() ? 1.0 : input::parse_quantity("1 " + m.unit).value;
  m.figure = figure;
  sheet.measurements.push_back(std::move(m));
}

}  // namespace

const std::vector<Column>& columns() {
  static const std::vector<Column> all = declared();
  return all;
}

const std::vector<std::string>& unused_names(const std::string& section) {
  static const std::vector<std::string> none, kes{"RT", "LC", "WC", "RC", "MIU", "MMD", "SMD"},
      fast{"T100", "ST", "T2R", "T100R", "STR", "F-1", "F-2", "RS-1", "RS-2", "HE-1", "HE-2"};
  return section == "kes" ? kes : section == "fast" ? fast : none;
}

int line_of(const toml::node& node) {
  return static_cast<int>(node.source().begin.line);
}

Figure read_figure(const Sheet& sheet, const std::string& key, const std::vector<Dimension>& dimensions,
                   const std::string& unit, const toml::node& node) {
  std::vector<Reading> readings;
  const toml::array* list = node.as_array();
  if (list && list->empty()) sheet.fail(line_of(node), key, "the list is empty; give a figure for each specimen");
  if (!list) return summary_of({read_item(sheet, key, dimensions, unit, node)});
  for (const toml::node& item : *list) {
    readings.push_back(read_item(sheet, key, dimensions, unit, item));
    if (list->size() > 1 && readings.back().deviation > 0.0)
      sheet.fail(line_of(item), key, "several specimens show the uncertainty by themselves; leave out +-");
  }
  return summary_of(readings);
}

void read_column(Sheet& sheet, const Column& column, const toml::node& node) {
  const std::string key = (column.section.empty() ? "" : column.section + ".") + column.key;
  const bool directed = !column.parts.front().first.empty();
  const toml::table* table = node.as_table();
  if (table && !directed) sheet.fail(line_of(node), key, "it has no direction; a figure or a list is needed");
  if (!table) {
    const Figure figure = read_figure(sheet, key, column.dimensions, column.unit, node);
    for (std::size_t i = 0; i < std::min<std::size_t>(column.parts.size(), 2); ++i) {
      add(sheet, column, column.parts[i].first, column.parts[i].second, figure, line_of(node));
      sheet.measurements.back().shared = directed;
    }
    return;
  }
  std::vector<std::string> valid;
  for (const auto& part : column.parts) valid.push_back(part.first);
  for (const auto& [name, value] : *table) {
    const std::string direction(name.str());
    if (column.key == "overhang" && direction == "angle") continue;
    if (column.key == "heart_loop" && direction == "length") continue;
    if ((column.key == "overhang" || column.key == "bending_length") && direction == "width") continue;
    const auto part = std::find(valid.begin(), valid.end(), direction);
    if (part == valid.end())
      sheet.fail(line_of(value), key, fmt::format("unknown name '{}':{}", direction, suggestion(direction, valid)));
    add(sheet, column, direction, column.parts[static_cast<std::size_t>(part - valid.begin())].second,
        read_figure(sheet, key + "." + direction, column.dimensions, column.unit, value), line_of(value));
  }
}

}  // namespace voile::fit

#include "unit_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/length_unit.hpp"
#include "base/text.hpp"
#include "base/time_unit.hpp"
#include "units.hpp"
#include "voile/errors.hpp"

namespace voile::input {

namespace {

struct Named {
  const char* name;
  double si;
  Powers powers;
};

constexpr Powers none{}, length{1, 0, 0}, mass{0, 1, 0}, duration{0, 0, 1}, force{1, 1, -2}, pressure{-1, 1, -2},
    energy{2, 1, -2}, frequency{0, 0, -1}, temperature{0, 0, 0, 1};
constexpr double pound = 0.45359237, standard_gravity = 9.80665;

/// The first of each kind is SI's.
const std::vector<Named>& named_units() {
  static const std::vector<Named> all = [] {
    std::vector<Named> units;
    for (const LengthUnit& unit : length_units) units.push_back({unit.name, unit.metres, length});
    for (const TimeUnit& unit : time_units) units.push_back({unit.name, unit.seconds, duration});
    const std::vector<Named> others{{"kg", 1.0, mass},
                                    {"g", 1e-3, mass},
                                    {"mg", 1e-6, mass},
                                    {"t", 1e3, mass},
                                    {"lb", pound, mass},
                                    {"oz", pound / 16.0, mass},
                                    {"slug", pound * standard_gravity / (12.0 * inch), mass},
                                    {"slinch", pound * standard_gravity / inch, mass},
                                    {"N", 1.0, force},
                                    {"mN", 1e-3, force},
                                    {"uN", 1e-6, force},
                                    {"kN", 1e3, force},
                                    {"MN", 1e6, force},
                                    {"gf", 1e-3 * standard_gravity, force},
                                    {"kgf", standard_gravity, force},
                                    {"lbf", pound * standard_gravity, force},
                                    {"Pa", 1.0, pressure},
                                    {"kPa", 1e3, pressure},
                                    {"MPa", 1e6, pressure},
                                    {"GPa", 1e9, pressure},
                                    {"bar", 1e5, pressure},
                                    {"psi", pound * standard_gravity / (inch * inch), pressure},
                                    {"ksi", 1e3 * pound * standard_gravity / (inch * inch), pressure},
                                    {"J", 1.0, energy},
                                    {"mJ", 1e-3, energy},
                                    {"Hz", 1.0, frequency},
                                    {"K", 1.0, temperature},
                                    {"rad", 1.0, none},
                                    {"deg", degree, none},
                                    {"degree", degree, none},
                                    {"%", 1e-2, none}};
    units.insert(units.end(), others.begin(), others.end());
    return units;
  }();
  return all;
}

MeasuredUnit power(const MeasuredUnit& unit, int n) {
  const Powers& p = unit.powers;
  return {std::pow(unit.si, n), {n * p.length, n * p.mass, n * p.time, n * p.temperature}};
}

MeasuredUnit product(const MeasuredUnit& a, const MeasuredUnit& b) {
  const Powers &p = a.powers, &q = b.powers;
  return {a.si * b.si, {p.length + q.length, p.mass + q.mass, p.time + q.time, p.temperature + q.temperature}};
}

/// Signs that laboratories print, in ASCII.
std::string in_ascii(std::string text) {
  const std::vector<std::pair<std::string, std::string>> same{{"\u00b7", "."}, {"\u00b2", "2"}, {"\u00b3", "3"},
                                                              {"\u00b5", "u"}, {"\u03bc", "u"}, {"\u00b0", "deg"}};
  for (const auto& [from, to] : same)
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from))
      text.replace(at, from.size(), to);
  return text;
}

/// Recursive descent: product = factor { (blank | . | *) factor | / factor }, factor = (name | 1 | "(" product ")") [^] power.
class Parser {
 public:
  explicit Parser(const std::string& text) : whole_(text), text_(in_ascii(text)) {}

  MeasuredUnit whole() {
    const MeasuredUnit unit = product_of();
    if (at_ < text_.size()) fail();
    return unit;
  }

 private:
  MeasuredUnit product_of() {
    MeasuredUnit unit = factor();
    for (;;) {
      skip(" .*");
      if (at_ >= text_.size() || text_[at_] == ')') return unit;
      const bool below = text_[at_] == '/';
      if (below) ++at_;
      skip(" ");
      unit = product(unit, below ? power(factor(), -1) : factor());
    }
  }
  MeasuredUnit factor() {
    MeasuredUnit unit;
    if (at_ < text_.size() && text_[at_] == '(') {
      if (++depth_ > deepest) fail();
      ++at_;
      unit = product_of();
      if (at_ >= text_.size() || text_[at_] != ')') fail();
      ++at_;
      --depth_;
    } else if (at_ < text_.size() && text_[at_] == '1') {
      ++at_;
      return unit;
    } else {
      unit = name();
    }
    return power(unit, exponent());
  }
  MeasuredUnit name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (std::isalpha(static_cast<unsigned char>(text_[at_])) || text_[at_] == '%')) ++at_;
    const std::string name = text_.substr(begin, at_ - begin);
    std::vector<std::string> names;
    for (const Named& n : named_units()) {
      if (name == n.name) return {n.si, n.powers};
      names.emplace_back(n.name);
    }
    if (name.empty()) fail();
    throw UserError(fmt::format("unknown unit '{}':{}", name, suggestion(name, names)));
  }
  int exponent() {
    const bool raised = at_ < text_.size() && text_[at_] == '^';
    if (raised) ++at_;
    const bool negative = at_ + 1 < text_.size() && text_[at_] == '-';
    const std::size_t digit = at_ + (negative ? 1 : 0);
    if (digit >= text_.size() || text_[digit] < '1' || text_[digit] > '9') {
      if (raised) fail();
      return 1;
    }
    at_ = digit + 1;
    return (negative ? -1 : 1) * (text_[digit] - '0');
  }
  void skip(const char* characters) { at_ = std::min(text_.find_first_not_of(characters, at_), text_.size()); }
  [[noreturn]] void fail() const {
    throw UserError(fmt::format("'{}' is not a unit; write one as N/mm^2, g/m^2 or kN m", whole_));
  }

  static constexpr int deepest = 4;
  std::string whole_, text_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

double unit_of(const char* key, const std::string& name, const Powers& powers) {
  MeasuredUnit unit;
  std::vector<std::string> known, fitting;
  for (const Named& n : named_units()) {
    known.emplace_back(n.name);
    if (n.powers == powers) fitting.emplace_back(n.name);
  }
  const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0; };
  if (std::all_of(name.begin(), name.end(), is_letter) && !contains(known, name))
    throw UserError(fmt::format("{}: unknown unit '{}':{}", key, name, suggestion(name, fitting)));
  try {
    unit = parse_unit(name);
  } catch (const UserError& e) {
    throw UserError(fmt::format("{}: {}", key, e.what()));
  }
  if (unit.powers != powers)
    throw UserError(fmt::format("{}: '{}' does not measure it; choose one of: {}", key, name, examples_of(powers)));
  return unit.si;
}

}  // namespace

MeasuredUnit parse_unit(const std::string& text) {
  return Parser(text).whole();
}

UnitSystem::UnitSystem(const UnitsSection& names)
    : names_(names),
      length_(unit_of("length", names.length, length)),
      mass_(unit_of("mass", names.mass, mass)),
      time_(unit_of("time", names.time, duration)) {}

double UnitSystem::from_si(double value, const Powers& p) const {
  if (is_si()) return value;
  return value / (std::pow(length_, p.length) * std::pow(mass_, p.mass) * std::pow(time_, p.time));
}

double UnitSystem::number(const std::string& text, const std::string& unit) const {
  const std::size_t begin = std::min(text.find_first_not_of(" +"), text.size());
  double value = 0.0;
  const auto [end, problem] = std::from_chars(text.data() + begin, text.data() + text.size(), value);
  if (problem != std::errc() || !std::isfinite(value))
    throw UserError(fmt::format("a number, or a number and a unit in quotes, is needed, e.g. \"1.5 {}\"", unit));
  const std::size_t at = text.find_first_not_of(' ', static_cast<std::size_t>(end - text.data()));
  if (at == std::string::npos) throw UserError("the unit is missing; add it, or write the number without quotes");
  const MeasuredUnit given = parse_unit(text.substr(at, text.find_last_not_of(' ') + 1 - at)),
                     wanted = parse_unit(unit);
  if (given.powers != wanted.powers)
    throw UserError(fmt::format("a unit like these is needed: {}", examples_of(wanted.powers)));
  if (wanted.si != 1.0) return value * given.si / wanted.si;
  return from_si(value * given.si, wanted.powers);
}

double UnitSystem::own_default(double value, const std::string& unit) const {
  if (is_si() || value == 0.0) return value;
  const MeasuredUnit own = parse_unit(unit);
  return own.si == 1.0 ? from_si(value, own.powers) : value;
}

std::string UnitSystem::label_of_name(const std::string& name) const {
  const MeasuredUnit unit = parse_unit(name);
  const Powers& p = unit.powers;
  if (p == none || unit.si != 1.0) return name;
  const double own = unit.si / from_si(unit.si, p);
  for (const Named& n : named_units())
    if (n.powers == p && std::abs(n.si / own - 1.0) < 1e-12) return n.name;
  std::string above, below;
  for (const auto& [base, power] : {std::pair(names_.length, p.length), {names_.mass, p.mass}, {names_.time, p.time}}) {
    std::string& side = power > 0 ? above : below;
    if (power != 0 && !side.empty()) side += ' ';
    if (power != 0) side += base;
    if (std::abs(power) > 1) side += fmt::format("^{}", std::abs(power));
  }
  if (above.empty()) above += '1';
  if (below.empty()) return above;
  const bool several = below.find(' ') != std::string::npos;
  return several ? fmt::format("({}/({}))", above, below) : fmt::format("({}/{})", above, below);
}

std::string UnitSystem::label(const std::string& unit) const {
  if (is_si()) return unit;
  std::string text;
  for (std::size_t at = 0; at < unit.size();) {
    std::size_t end = at;
    while (end < unit.size() && std::isalpha(static_cast<unsigned char>(unit[end]))) ++end;
    const bool named = end > at;
    if (!named) ++end;
    text += named ? label_of_name(unit.substr(at, end - at)) : unit.substr(at, 1);
    at = end;
  }
  return text;
}

std::string unit_for(const std::string& key_unit, const std::string& type) {
  if (key_unit.find(',') == std::string::npos) return key_unit == "file unit" ? "" : key_unit;
  std::size_t begin = 0;
  bool named = false;
  while (begin < key_unit.size()) {
    const std::size_t end = std::min(key_unit.find(',', begin), key_unit.size());
    const std::string item = key_unit.substr(begin, end - begin);
    const std::size_t blank = item.find(' ');
    named = named || (!type.empty() && item.substr(0, blank) == type);
    if (named && blank != std::string::npos) return item.substr(blank + 1);
    begin = end + 2;
  }
  return "";
}

std::string examples_of(const Powers& powers) {
  std::vector<std::string> found;
  for (const Named& n : named_units())
    if (n.powers == powers) found.emplace_back(n.name);
  for (const char* compound :
       {"m/s", "mm/s", "m/s^2", "kg/m^2", "g/m^2", "kg/m^3", "g/cm^3", "t/mm^3", "N/m",    "N/mm", "gf/cm",
        "N m", "mN m", "N/m^3", "N/mm^3", "1/s",   "rad/s",  "1/m",    "1/mm",   "kg m^2", "1/K",  "1/(m K)"})
    if (parse_unit(compound).powers == powers) found.emplace_back(compound);
  return join(found, ", ");
}

}  // namespace voile::input

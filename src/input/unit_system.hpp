// Units of a case: "210 GPa" instead of a number, and [units] for a case that is not in SI.
//
// A case is in one consistent system: a unit of length, of mass and of time. Plain numbers are in it, texts with a unit are
// converted to it, and so are defaults and fabrics, which are kept in SI. The solver knows nothing of it: all formulas hold in
// every consistent system.
#pragma once

#include <string>
#include <vector>

namespace voile::input {

/// Powers of length, mass, time and temperature.
struct Powers {
  int length = 0, mass = 0, time = 0, temperature = 0;
  [[nodiscard]] bool operator==(const Powers&) const = default;
};

/// A unit: its size in m, kg and s, with angles in radians.
struct MeasuredUnit {
  double si = 1.0;
  Powers powers;
};

/// Reads products, quotients and powers of named units, e.g. "N/mm^2", "g/m^2", "kN m", "1/s".
/// Throws UserError without a place: an unknown name, with the nearest known one.
[[nodiscard]] MeasuredUnit parse_unit(const std::string& text);

/// What the keys of [units] set: names of units.
struct UnitsSection {
  std::string length = "m", mass = "kg", time = "s";
};

/// One consistent system.
class UnitSystem {
 public:
  UnitSystem() = default;
  /// Throws UserError without a place if a name is no unit of what it stands for.
  explicit UnitSystem(const UnitsSection& names);
  [[nodiscard]] bool is_si() const { return length_ == 1.0 && mass_ == 1.0 && time_ == 1.0; }
  /// An SI value in this system.
  [[nodiscard]] double from_si(double value, const Powers& powers) const;
  /// `text` "NUMBER UNIT" as a number in `unit`, which is a key's: a coherent SI unit stands for that of this system.
  /// Throws UserError without a place: no number, no unit, another dimension.
  [[nodiscard]] double number(const std::string& text, const std::string& unit) const;
  /// A default in SI as a number of this system.
  [[nodiscard]] double own_default(double value, const std::string& unit) const;
  /// An SI unit as this system has it, for labels: "Pa" is "MPa" in mm, t and s. Names without a prefix of their own are
  /// written in length, mass and time, "N" in in, lb and s as "(in lb/s^2)". Throws UserError as parse_unit().
  [[nodiscard]] std::string label(const std::string& unit) const;

 private:
  [[nodiscard]] std::string label_of_name(const std::string& name) const;

  UnitsSection names_;
  double length_ = 1.0, mass_ = 1.0, time_ = 1.0;
};

/// Unit of a key in a section of this type: its text may be a list by type, "point N, line N/m". Empty if it names none.
[[nodiscard]] std::string unit_for(const std::string& key_unit, const std::string& type);

/// E.g. "N/mm^2, MPa": some names of units with these powers.
[[nodiscard]] std::string examples_of(const Powers& powers);

}  // namespace voile::input

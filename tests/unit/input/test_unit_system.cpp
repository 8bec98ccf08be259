// Numbers with units in cases, and cases that are not in SI.
#include "input/unit_system.hpp"

#include <numbers>
#include <string>
#include <vector>

#include "test_case_kit.hpp"
#include "test_case_texts.hpp"

namespace test_unit_system {

using namespace voile;
using namespace voile::testing;
using input::parse_unit;
using input::Powers;
using input::UnitSystem;

TEST_CASE("units are products, quotients and powers of named ones") {
  struct Known {
    const char* text;
    double si;
    Powers powers;
  };
  for (const Known& k :
       {Known{"N/mm^2", 1e6, {-1, 1, -2}}, Known{"GPa", 1e9, {-1, 1, -2}}, Known{"g/m2", 1e-3, {-2, 1, 0}},
        Known{"kN m", 1e3, {2, 1, -2}}, Known{"kN.m", 1e3, {2, 1, -2}}, Known{"1/s", 1.0, {0, 0, -1}},
        Known{"s^-1", 1.0, {0, 0, -1}}, Known{"kg/(m s^2)", 1.0, {-1, 1, -2}}, Known{"m/s/s", 1.0, {1, 0, -2}},
        Known{"gf.cm^2/cm", 9.80665e-5, {2, 1, -2}}, Known{"\u00b5m", 1e-6, {1, 0, 0}},
        Known{"t/mm^3", 1e12, {-3, 1, 0}}, Known{"\u00b0", std::numbers::pi / 180.0, {}}}) {
    CAPTURE(k.text);
    CHECK(parse_unit(k.text).si == doctest::Approx(k.si).epsilon(1e-14));
    CHECK(parse_unit(k.text).powers == k.powers);
  }
  for (const std::string& wrong :
       std::vector<std::string>{"", "/", "N/", "(N", "N)", "N^", "5 N", "N/mm^^2", "((((((m))))))"}) {
    CAPTURE(wrong);
    CHECK(error_of([&] { (void)parse_unit(wrong); }) != "no error");
  }
  CHECK(has(error_of([] { (void)parse_unit("Mpa"); }), "did you mean 'MPa'"));
}

TEST_CASE("a text with a unit becomes a number of the key's unit in the case's system") {
  const UnitSystem si, millimetres({"mm", "t", "s"});
  CHECK(si.number("210 GPa", "Pa") == doctest::Approx(210e9).epsilon(1e-14));
  CHECK(millimetres.number("210 GPa", "Pa") == doctest::Approx(210e3).epsilon(1e-14));
  CHECK(millimetres.number("7850 kg/m^3", "kg/m^3") == doctest::Approx(7.85e-9).epsilon(1e-14));
  CHECK(millimetres.number("0.5 rad", "degree") == doctest::Approx(90.0 / std::numbers::pi).epsilon(1e-14));
  CHECK(millimetres.number("90 s", "min") == doctest::Approx(1.5).epsilon(1e-14));
  CHECK(millimetres.own_default(1e-3, "m") == doctest::Approx(1.0).epsilon(1e-14));
  CHECK(millimetres.own_default(30.0, "degree") == 30.0);
  CHECK(si.own_default(1e-3, "m") == 1e-3);
  CHECK(has(error_of([&] { (void)si.number("210 GPa", "m"); }), "a unit like these is needed: m, cm, mm"));
  CHECK(has(error_of([&] { (void)si.number("210", "Pa"); }), "the unit is missing"));
  CHECK(has(error_of([&] { (void)si.number("nan Pa", "Pa"); }), "a number"));
  CHECK(has(error_of([&] { (void)si.number("1e999 Pa", "Pa"); }), "a number"));
  CHECK(has(error_of([] { (void)UnitSystem({"kg", "kg", "s"}); }), "length: 'kg' does not measure it"));
}

TEST_CASE("labels of fields are in the units of the case") {
  const UnitSystem si, millimetres({"mm", "t", "s"}), inches({"in", "lb", "s"}), fast({"mm", "g", "ms"});
  CHECK(si.label("J/m^2") == "J/m^2");
  CHECK(millimetres.label("Pa") == "MPa");
  CHECK(millimetres.label("N/m") == "N/mm");
  CHECK(millimetres.label("J/m^2") == "mJ/mm^2");
  CHECK(millimetres.label("m/s") == "mm/s");
  CHECK(millimetres.label("rad") == "rad");
  CHECK(millimetres.label("1") == "1");
  CHECK(inches.label("N") == "(in lb/s^2)");
  CHECK(inches.label("Pa") == "(lb/(in s^2))");
  CHECK(fast.label("Pa") == "MPa");
  CHECK(fast.label("m/s") == "mm/ms");
}

TEST_CASE("the unit of a key may depend on the type of its section") {
  const std::string loads = "point N, line N/m, area N/m^2, gravity m/s^2", springs = "point, pair N/m, line N/m^2";
  CHECK(input::unit_for(loads, "area") == "N/m^2");
  CHECK(input::unit_for(springs, "point") == "N/m");
  CHECK(input::unit_for(springs, "pair") == "N/m");
  CHECK(input::unit_for("points N/m, curves N/m^2", "") == "");
  CHECK(input::unit_for("N m", "point") == "N m");
  CHECK(input::unit_for("file unit", "") == "");
}

TEST_CASE("cases with units") {
  const std::string with_units = R"(
[mesh]
file = "a.msh"
[[material]]
type = "isotropic"
young = "210 GPa"
poisson = 0.3
thickness = "0.5 mm"
density = "7.85 g/cm^3"
[[load]]
type = "line"
group = "tip"
vector = [0, 0, "2 N/mm"]
[[load]]
type = "pressure"
magnitude = "1 bar"
[contact]
friction = 0.2
)";
  const input::Case si = input::parse_case(with_units, "case.toml");
  CHECK(si.materials.front().areal_density == doctest::Approx(7850 * 5e-4).epsilon(1e-14));
  CHECK(si.loads[0].vector.z() == doctest::Approx(2e3).epsilon(1e-14));
  CHECK(si.loads[1].magnitude == doctest::Approx(1e5).epsilon(1e-14));
  const std::string declared = "[units]\nlength = \"mm\"\nmass = \"t\"\n" + with_units;
  const input::Case mm = input::parse_case(declared, "case.toml");
  CHECK(mm.materials.front().membrane(0, 0) ==
        doctest::Approx(1e-3 * si.materials.front().membrane(0, 0)).epsilon(1e-13));
  CHECK(mm.loads[0].vector.z() == doctest::Approx(2.0).epsilon(1e-14));
  CHECK(mm.loads[1].magnitude == doctest::Approx(0.1).epsilon(1e-14));
  CHECK(mm.contact.input.options.distance == doctest::Approx(1e3 * si.contact.input.options.distance).epsilon(1e-14));
  CHECK(mm.time.options.velocity_tolerance == doctest::Approx(1e3 * si.time.options.velocity_tolerance).epsilon(1e-14));
  CHECK(mm.time.options.step == si.time.options.step);

  SUBCASE("the echo is the same case") {
    const input::Case again = input::parse_case(input::echo_case(mm), "case.toml");
    CHECK(again.contact.input.options.distance == mm.contact.input.options.distance);
    CHECK(again.loads[1].magnitude == mm.loads[1].magnitude);
    CHECK(again.units.length == "mm");
  }
  SUBCASE("mistakes") {
    CHECK(error_of(replaced(with_units, "210 GPa", "210 N/m")) ==
          "case.toml:6: material.young: '210 N/m': a unit like these is needed: Pa, kPa, MPa, GPa, bar, psi, ksi");
    CHECK(has(error_of(replaced(with_units, "210 GPa", "-210 GPa")), "must be > 0 [Pa]"));
    CHECK(has(error_of(replaced(with_units, "2 N/mm", "2 MPa")), "case.toml:13: load.vector"));
    CHECK(has(error_of(replaced(with_units, "0.3", "\"30 %\"")), "without quotes"));
    CHECK(has(error_of(replaced(declared, "\"mm\"", "\"s\"")), "units.length: 's' does not measure it"));
    CHECK(has(error_of(replaced(declared, "\"mm\"", "\"mmm\"")), "unknown unit 'mmm'"));
  }
}

}  // namespace test_unit_system

// Fabric files: units against figures worked out by hand, every kind of mistake, the shipped fabrics, the warp angle.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "energy/material.hpp"
#include "input/case.hpp"
#include "input/fabric.hpp"
#include "input/units.hpp"
#include "test_case_kit.hpp"
#include "test_fabric_text.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_fabric {

using namespace voile;
using namespace voile::testing;
using input::Dimension;

namespace {

double difference(const Mat3& a, const Mat3& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

/// A fabric file and a case beside it.
class FabricCase {
 public:
  explicit FabricCase(const std::string& fabric) : file_(".toml", fabric) {}
  /// `keys` of the material; its fabric is F.
  [[nodiscard]] input::Case parse(std::string keys) const {
    if (const std::size_t at = keys.find('F'); at != std::string::npos) keys.replace(at, 1, name());
    return input::parse_case("[mesh]\nfile = \"a.geo\"\n[[material]]\ntype = \"fabric\"\n" + keys,
                             file_.path().parent_path() / "case.toml");
  }
  [[nodiscard]] std::string name() const { return file_.path().filename().string(); }

 private:
  testing::TemporaryFile file_;
};

}  // namespace

TEST_CASE("fabric: every unit against a figure worked out by hand") {
  struct Example {
    const char* text;
    double si;
    Dimension dimension;
  };
  const std::vector<Example> examples{
      {"0.3 m", 0.3, Dimension::length},
      {"0.497 mm", 0.000497, Dimension::length},
      {"250 um", 0.00025, Dimension::length},
      {"0.2 kg/m^2", 0.2, Dimension::mass_per_area},
      {"123.8 g/m^2", 0.1238, Dimension::mass_per_area},
      {"12.38 mg/cm^2", 0.1238, Dimension::mass_per_area},
      {"11 oz/yd^2", 0.372963, Dimension::mass_per_area},  // 11 x 0.02834952 / 0.83612736
      {"490 N/m", 490.0, Dimension::force_per_length},
      {"2.5 kN/m", 2500.0, Dimension::force_per_length},
      {"500 gf/cm", 490.3325, Dimension::force_per_length},
      {"1 gf/(cm.deg)", 56.18797, Dimension::shear_rigidity},  // 0.980665 x 57.29578
      {"3e-6 N.m", 3e-6, Dimension::bending_rigidity},
      {"14 uN.m", 1.4e-5, Dimension::bending_rigidity},
      {"0.077 gf.cm^2/cm", 7.5511205e-6, Dimension::bending_rigidity},  // 0.077 x 98.0665e-6
      {"0.124 gf.cm/cm", 1.2160246e-3, Dimension::moment_per_width},
      {"0.05 1/cm", 5.0, Dimension::curvature},
      {"4.2 %", 0.042, Dimension::extension},
      {"8 deg", 0.13962634, Dimension::angle},
      {"9.5 gf.cm/cm^2", 9.3163175, Dimension::energy_per_area},  // 9.5 x 0.980665
      {"18.5 mm FAST", 0.0185, Dimension::fast_bending_length},
  };
  for (const Example& e : examples) {
    CAPTURE(e.text);
    const input::Quantity q = input::parse_quantity(e.text);
    CHECK(q.value == relative(e.si).epsilon(1e-6));
    CHECK(q.dimension == e.dimension);
  }
  // 9.81e-6 x 200 x 18.5^3 = 12.4226 uN m
  CHECK(input::bending_rigidity(0.2, 0.0185) == relative(12.42265e-6).epsilon(1e-5));
}

TEST_CASE("fabric: a unit may be written in several ways") {
  for (const char* text : {"2gf.cm^2/cm", " 2  gf cm2 / cm ", "2 gf*cm^2/cm", "2 gf\u00b7cm\u00b2/cm"})
    CHECK(input::parse_quantity(text).value == relative(2 * 98.0665e-6).epsilon(1e-12));
  for (const char* text : {"3 gf/cm.deg", "3 gf/(cm deg)", "3 gf/cm/deg", "3 gf/(cm.degree)"})
    CHECK(input::parse_quantity(text).value == relative(3 * 56.18797).epsilon(1e-6));
  for (const char* text : {"5 \u00b5N m", "5uNm", "5 uN*m"}) CHECK(input::parse_quantity(text).value == relative(5e-6));
  CHECK(input::parse_quantity("5 g / m2").value == relative(5e-3));
  CHECK(input::parse_quantity("5 mm  FAST").dimension == Dimension::fast_bending_length);
}

TEST_CASE("fabric: figures that are not a number with a known unit") {
  const auto message = [](const char* text) { return error_of([&] { (void)input::parse_quantity(text); }); };
  CHECK(message("0.3") == "'0.3': the unit is missing; add it, or write an SI number without quotes");
  CHECK(has(message("gf/cm"), "a number and a unit are needed"));
  CHECK(has(message(""), "a number and a unit are needed"));
  CHECK(has(message("inf N/m"), "a number and a unit are needed"));
  CHECK(has(message("1,5 N/m"), "unknown unit ',5 N/m'"));
  CHECK(has(message("0.1 gf.cm^2/m"), "unknown unit 'gf.cm^2/m': did you mean 'gf.cm^2/cm'?"));
  CHECK(has(message("3 furlong"), "unknown unit 'furlong': valid: m, mm, um, kg/m^2"));
  CHECK(has(message("1 NM"), "unknown unit 'NM'"));
  CHECK(has(message("1 m.m"), "unknown unit 'm.m'"));
}

TEST_CASE("fabric: the stiffness from its figures") {
  const input::Fabric f = input::parse_fabric(fabric_text, "f.toml");
  CHECK(f.areal_density == relative(0.2));
  CHECK(!f.thickness);
  const Mat3 a = input::membrane_stiffness(f), d = input::bending_stiffness(f);
  CHECK(a(0, 0) == relative(2000.0));
  CHECK(a(1, 1) == 500.0);
  CHECK(a(2, 2) == relative(56.18797).epsilon(1e-6));
  CHECK(a(0, 1) == 0.0);
  CHECK(d(0, 0) == relative(9.80665e-6));
  CHECK(d(1, 1) == relative(4e-6));
  CHECK(d(2, 2) == relative(0.5 * std::sqrt(9.80665 * 4.0) * 1e-6));

  const std::string more = replaced(replaced(fabric_text, "[sources]\n",
                                             "bending_poisson = 0.2\nmembrane_poisson = -0.1\nthickness = 3e-4\n"
                                             "[sources]\nbending_poisson = \"x\"\nmembrane_poisson = \"x\"\n"
                                             "thickness = \"x\"\n"),
                                    "\"4 uN.m\"", "\"18.5 mm FAST\"");
  const input::Fabric g = input::parse_fabric(more, "f.toml");
  CHECK(g.thickness == relative(3e-4));
  CHECK(input::membrane_stiffness(g)(0, 1) == relative(-0.1 * 1000.0));
  const Mat3 dg = input::bending_stiffness(g);
  CHECK(dg(1, 1) == relative(12.42265e-6).epsilon(1e-5));
  CHECK(dg(1, 0) == relative(0.2 * std::sqrt(dg(0, 0) * dg(1, 1))));
  CHECK(dg(2, 2) == relative(0.4 * std::sqrt(dg(0, 0) * dg(1, 1))));
  // Of an isotropic sheet the rule makes an isotropic stiffness.
  input::Fabric i = g;
  i.bending_weft = i.bending_warp;
  CHECK(difference(energy::rotated_stiffness(input::bending_stiffness(i), 0.7), input::bending_stiffness(i)) < 1e-14);
  i.bending_twist = 5e-6;
  CHECK(input::bending_stiffness(i)(2, 2) == 5e-6);
}

TEST_CASE("fabric: damping from the loop of bending") {
  // B = sqrt(9.80665 * 4) uN m, 0.2 kg/m^2, g = 9.80665 m/s^2: bending length l and sqrt(l/g).
  const input::Fabric f = input::parse_fabric(fabric_text, "f.toml");
  const double length = std::cbrt(std::sqrt(9.80665 * 4.0) * 1e-6 / (0.2 * 9.80665));
  const double unit = 2.0 * length * std::sqrt(length / 9.80665) / M_PI;
  CHECK(input::bending_damping(f) == relative(unit * input::typical_hysteresis).epsilon(1e-4));
  const std::string measured = replaced(
      fabric_text, "[sources]\n", "bending_hysteresis = \"0.02 gf.cm/cm\"\n[sources]\nbending_hysteresis = \"x\"\n");
  const double loop = 0.02 * 9.80665e-3 / (std::sqrt(9.80665 * 4.0) * 1e-6);
  CHECK(input::bending_damping(input::parse_fabric(measured, "f.toml")) == relative(unit * loop).epsilon(1e-4));
  // In a case: the fabric's, unless the material says its own.
  const FabricCase plain(fabric_text);
  const std::string keys = "fabric = \"F\"\ndirection = [1, 0, 0]\n";
  CHECK(plain.parse(keys).materials.at(0).bending_damping == relative(input::bending_damping(f)));
  CHECK(plain.parse(keys + "bending_damping = 0\n").materials.at(0).bending_damping == 0.0);
  CHECK(plain.parse(keys + "bending_damping = 0.1\nmembrane_damping = 0.2\n").materials.at(0).bending_damping == 0.1);
  CHECK(plain.parse(keys + "membrane_damping = 0.2\n").materials.at(0).viscous_time == 0.2);
}

TEST_CASE("fabric: friction from the loop of bending") {
  const std::string measured =
      replaced(fabric_text, "[sources]\n",
               "bending_hysteresis = \"0.02 gf.cm/cm\"\nbending_hysteresis_weft = \"0.1 mN\"\n"
               "bending_hysteresis_spread = \"0.05 1/cm\"\n[sources]\nbending_hysteresis = \"x\"\n"
               "bending_hysteresis_weft = \"x\"\nbending_hysteresis_spread = \"x\"\n");
  const FabricCase rubs(measured);
  const std::string keys = "fabric = \"F\"\ndirection = [1, 0, 0]\nwarp_angle = 30\n";
  // What a file has does not act before it is asked for.
  CHECK(rubs.parse(keys).materials.at(0).friction.sliders.empty());
  const energy::Material m = rubs.parse(keys + "hysteresis = \"friction\"\n").materials.at(0);
  REQUIRE(m.friction.sliders.size() == 1);
  CHECK(m.friction.warp_angle == relative(std::numbers::pi / 6.0));
  CHECK(m.bending_damping == 0.0);
  const energy::YarnFriction::Slider s = m.friction.sliders[0];
  CHECK(s.limit[0] == relative(0.01 * 9.80665e-3));
  CHECK(s.limit[1] == relative(0.05e-3));
  CHECK(s.limit[2] == 0.0);
  CHECK(s.stiffness[0] == relative(0.02 * 9.80665e-3 / 5.0));  // 2HB over the spread
  // Several sliders: the same width and the same mean spread; and what is echoed is read as the same.
  const input::Case several = rubs.parse(keys + "hysteresis = \"friction\"\nbending_sliders = 3\n");
  const energy::YarnFriction& f = several.materials.at(0).friction;
  REQUIRE(f.sliders.size() == 3);
  Vec3 sum = Vec3::Zero();
  double spread = 0.0;
  for (const auto& one : f.sliders) {
    sum += one.limit;
    spread += 2.0 * one.limit[0] / one.stiffness[0] / 3.0;
  }
  CHECK((sum - s.limit).norm() < 1e-15);
  CHECK(spread == relative(5.0));
  const input::Case again = input::parse_case(input::echo_case(several), "again.toml");
  REQUIRE(again.materials.at(0).friction.sliders.size() == 3);
  CHECK(again.materials.at(0).friction.warp_angle == relative(f.warp_angle));
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK((again.materials.at(0).friction.sliders[k].limit - f.sliders[k].limit).norm() < 1e-15);
    CHECK((again.materials.at(0).friction.sliders[k].stiffness - f.sliders[k].stiffness).norm() < 1e-15);
  }
}

TEST_CASE("fabric: mistakes of friction") {
  const FabricCase plain(fabric_text);
  const std::string keys = "fabric = \"F\"\ndirection = [1, 0, 0]\n";
  CHECK(has(error_of([&] { (void)plain.parse(keys + "hysteresis = \"friction\"\n"); }),
            plain.name() + ": the file has neither bending_hysteresis nor shear_hysteresis"));
  CHECK(has(fabric_error("500", "500\nbending_hysteresis = \"0.124\""),
            "f.toml:6: bending_hysteresis: '0.124': the unit is missing"));
  CHECK(
      has(fabric_error("500", "500\nbending_hysteresis = -1e-3"), "f.toml:6: bending_hysteresis: the figure must be"));
  CHECK(has(fabric_error("500", "500\nbending_hysteresis = \"0.1 gf.cm^2/cm\""), "a moment per width is needed"));
  CHECK(has(fabric_error("500", "500\nbending_hysteresis_weft = \"0.1 gf.cm/cm\""),
            "f.toml:6: bending_hysteresis_weft: there is no bending_hysteresis"));
  const auto matrices = [&](const std::string& more) {
    return input::parse_case(
        "[mesh]\nfile = \"a.geo\"\n[[material]]\ntype = \"matrices\"\nmembrane = [[1, 0, 0], [0, 1, 0], [0, 0, 0.5]]\n"
        "bending = [[1, 0, 0], [0, 1, 0], [0, 0, 0.5]]\n" +
            more,
        "c.toml");
  };
  const std::string along = "direction = [1, 0, 0]\n";
  CHECK(matrices(along + "bending_hysteresis = [2e-4]\n").materials.at(0).friction.sliders.at(0).limit ==
        Vec3(1e-4, 1e-4, 0.0));
  CHECK(has(error_of([&] { (void)matrices("bending_hysteresis = [2e-4]\n"); }), "direction: the key is missing"));
  CHECK(has(error_of([&] { (void)matrices(along + "bending_hysteresis = [1, 2]\n"); }), "2 numbers are given"));
  CHECK(has(error_of([&] { (void)matrices(along + "bending_hysteresis = [-1]\n"); }), "bending_hysteresis"));
  CHECK(has(error_of([&] { (void)matrices(along + "bending_sliders = 0\n"); }), "bending_sliders"));
}

TEST_CASE("fabric: mistakes in a file are named with line and key") {
  CHECK(fabric_error("bending_warp = \"0.1", "bending_wrap = \"0.1") ==
        "f.toml:7: unknown key 'bending_wrap': did you mean 'bending_warp'?");
  CHECK(fabric_error("bending_weft = \"made", "bending_welt = \"made") ==
        "f.toml:15: [sources] unknown key 'bending_welt': did you mean 'bending_weft'?");
  CHECK(
      has(fabric_error("membrane_weft = 500\n", ""), "f.toml: membrane_weft: the key is missing; a force per length"));
  CHECK(has(fabric_error("name = \"Test\"\n", ""), "f.toml: name: the key is missing"));
  CHECK(has(fabric_error("\"Test\"", "\"  \""), "f.toml:1: name: a text in quotes is needed"));
  CHECK(fabric_error("\"0.1 gf.cm^2/cm\"", "\"120 g/m^2\"") ==
        "f.toml:7: bending_warp: '120 g/m^2' is a mass per area, a bending rigidity is needed: N.m, uN.m, gf.cm^2/cm, "
        "mm FAST");
  CHECK(has(fabric_error("\"2 kN/m\"", "\"2 gf/(cm.deg)\""), "is a shear rigidity per angle, a force per length"));
  CHECK(has(fabric_error("\"2 kN/m\"", "\"2 kN\""), "f.toml:4: membrane_warp: '2 kN': unknown unit 'kN'"));
  CHECK(has(fabric_error("500", "0"), "f.toml:5: membrane_weft: the figure must be finite and greater than zero"));
  CHECK(has(fabric_error("\"200 g/m^2\"", "\"200 kg/m^2\""), "f.toml:3: areal_density: 200 kg/m^2 is no fabric's"));
  CHECK(has(fabric_error("membrane_warp = \"2", "thickness = \"3 m\"\nmembrane_warp = \"2"),
            "thickness: 3 m is no fabric's"));
  CHECK(has(fabric_error("500", "nan"), "must be finite and greater than zero"));
  CHECK(has(fabric_error("500", "true"), "a number in SI units or a text with a unit is needed"));
  CHECK(has(fabric_error("500", "500\nmembrane_poisson = 1.0"),
            "f.toml:6: membrane_poisson: a number between -1 and 1 is needed; beyond, the stiffness is not positive"));
  const std::string singular = replaced(fabric_text, "[sources]\n",
                                        "membrane_poisson = 0.999999999999999\n[sources]\nmembrane_poisson = \"x\"\n");
  CHECK(has(error_of([&] { (void)input::parse_fabric(singular, "f.toml"); }),
            "f.toml:9: membrane_poisson: the membrane stiffness is not positive definite"));
  CHECK(has(fabric_error("500", "500\nbending_poisson = \"0.3\""), "f.toml:6: bending_poisson: a number between"));
  CHECK(has(fabric_error("500", "[500"), "f.toml:6: this is not valid TOML"));
}

TEST_CASE("fabric: a figure without a source is refused") {
  CHECK(fabric_error("bending_weft = \"made up\"\n", "") ==
        "f.toml:8: bending_weft: the source is missing; write in [sources] where this figure comes from: "
        "bending_weft = \"...\"");
  CHECK(has(fabric_error("500", "500\nthickness = \"1 mm\""), "f.toml:6: thickness: the source is missing"));
  CHECK(has(fabric_error("[sources]\n", "[sources]\nthickness = \"x\"\n"),
            "f.toml:10: sources.thickness: there is no such figure in this file"));
  CHECK(has(fabric_error("bending_weft = \"made up\"", "bending_weft = \"\""),
            "f.toml:15: sources.bending_weft: a text in quotes is needed"));
  const std::string without = fabric_text.substr(0, fabric_text.find("[sources]"));
  CHECK(has(error_of([&] { (void)input::parse_fabric(without, "f.toml"); }), "f.toml: sources: the table is missing"));
}

TEST_CASE("fabric: the warp angle turns the stiffness") {
  const FabricCase fabric_case(fabric_text);
  const input::Fabric f = input::parse_fabric(fabric_text, "f.toml");
  const Mat3 a = input::membrane_stiffness(f), d = input::bending_stiffness(f);
  const std::string keys = "fabric = \"F\"\ndirection = [0, 2, 0]\n";
  const energy::Material straight = fabric_case.parse(keys).materials.at(0);
  CHECK(straight.membrane == a);
  CHECK(straight.bending == d);
  CHECK(straight.areal_density == relative(0.2));
  CHECK(*straight.direction == Vec3(0, 2, 0));

  const double angle = 30.0 * (std::numbers::pi / 180.0);
  const input::Case c = fabric_case.parse(keys + "warp_angle = 30\ngroups = [\"sleeve\"]\n");
  const energy::Material turned = c.materials.at(0);
  CHECK(difference(turned.membrane, energy::rotated_stiffness(a, angle)) < 1e-14);
  CHECK(difference(turned.bending, energy::rotated_stiffness(d, angle)) < 1e-14);
  CHECK(turned.groups == std::vector<std::string>{"sleeve"});
  // Stretched along the warp, as unit strain along that direction in the axes of `direction`, it has the warp's energy.
  const double x = std::cos(angle), y = std::sin(angle);
  const Vec3 along(x * x, y * y, 2 * x * y);
  CHECK(along.dot(turned.membrane * along) == relative(a(0, 0)));
  const Mat3 quarter = fabric_case.parse(keys + "warp_angle = 90\n").materials.at(0).membrane;
  CHECK(quarter(0, 0) == relative(500.0));
  CHECK(quarter(1, 1) == relative(2000.0));

  const energy::Material echoed = input::parse_case(input::echo_case(c), "case.toml").materials.at(0);
  CHECK(echoed.membrane == turned.membrane);
  CHECK(echoed.bending == turned.bending);
  CHECK(echoed.direction == turned.direction);
}

TEST_CASE("fabric: an interlining is a second layer about the common middle") {
  const FabricCase fabric(fabric_text);
  const std::string keys = "fabric = \"F\"\ndirection = [1, 0, 0]\n", second = "interlining = \"silk_habutai\"\n";
  const energy::Material one = fabric.parse(keys).materials[0];
  const auto with = [&](const std::string& more) { return fabric.parse(keys + second + more).materials[0]; };
  const energy::Material fused = with("interlining_distance = 3e-4\n"),
                         loose = with("interlining_distance = 3e-4\ninterlining_bond = 0\n"),
                         turned = with("interlining_distance = 3e-4\ninterlining_angle = 90\n");
  // Silk of 1000 N/m along both yarns, 34.7 g/m^2, 1.1 and 0.9 uN m (runs/fabrics/silk_habutai.toml).
  CHECK(fused.membrane(0, 0) - one.membrane(0, 0) == relative(1000.0));
  CHECK(fused.areal_density - one.areal_density == relative(0.0347));
  CHECK(loose.bending(0, 0) - one.bending(0, 0) == relative(1.1e-6));
  CHECK(turned.bending(0, 0) - fused.bending(0, 0) == doctest::Approx(-0.2e-6).epsilon(1e-6));
  const Mat3 a2 = fused.membrane - one.membrane, series = (one.membrane.inverse() + a2.inverse()).inverse();
  CHECK(difference(fused.bending - loose.bending, 9e-8 * series) < 1e-9);
  const auto refused = [&](const std::string& more) { return error_of([&] { (void)fabric.parse(keys + more); }); };
  CHECK(has(refused("interlining = \"silk_habuti\""), "did you mean interlining = \"silk_habutai\""));
  CHECK(has(refused("interlining_bond = 0.5"), "material.interlining: the key is missing; interlining_bond"));
  CHECK(has(refused(second), "interlining_distance: the key is missing, and"));
  CHECK(has(refused(second + "interlining_bond = 2"), "interlining_bond: 2: must be >= 0 and <= 1"));
}

TEST_CASE("fabric: mistakes in the case") {
  const FabricCase fabric_case(replaced(fabric_text, "\"0.1 gf.cm^2/cm\"", "\"0.1\""));
  const auto message = [&](const std::string& keys) { return error_of([&] { (void)fabric_case.parse(keys); }); };
  CHECK(has(message("direction = [1, 0, 0]\n"), "case.toml:3: material.fabric: the key is missing; Fabric file"));
  CHECK(has(message("fabric = \"F\"\n"), "case.toml:3: material.direction: the key is missing"));
  CHECK(has(message("fabric = \"g.toml\"\ndirection = [1, 0, 0]\n"),
            "case.toml:5: material.fabric: there is no fabric file "));
  CHECK(has(message("fabric = \"F\"\ndirection = [1, 0, 0]\n"),
            fabric_case.name() + ":7: bending_warp: '0.1': the unit"));
  CHECK(has(message("fabric = \"F\"\ndirection = [1, 0, 0]\nthickness = 1\n"),
            "key 'thickness' does not belong to type 'fabric'"));
}

TEST_CASE("fabric: the shipped files are complete and realistic") {
  const std::filesystem::path folder = std::filesystem::path(VOILE_SOURCE_FOLDER) / "runs" / "fabrics";
  if (!std::filesystem::is_directory(folder)) {
    MESSAGE("skipped: there is no folder " << folder.string());
    return;
  }
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".toml") continue;
    const std::string name = entry.path().string();
    CAPTURE(name);
    const input::Fabric f = input::read_fabric(entry.path());
    CHECK(energy::is_positive_definite(input::membrane_stiffness(f)));
    CHECK(energy::is_positive_definite(input::bending_stiffness(f)));
    for (const double rigidity : {f.bending_warp, f.bending_weft}) {
      const double bending_length = std::cbrt(rigidity / (9.81 * f.areal_density));
      CHECK(bending_length > 0.010);
      CHECK(bending_length < 0.035);
    }
    // Folding must be far cheaper than stretching, as in every sheet thinner than a millimetre or so.
    CHECK(f.bending_warp / f.membrane_warp < 1e-6);
    CHECK(f.bending_weft / f.membrane_weft < 1e-6);
    ++count;
  }
  CHECK(count >= 6);
}

}  // namespace test_fabric

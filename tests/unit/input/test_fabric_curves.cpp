// Curves of fabric files: tension and shear as they are measured, the loop of shear, every kind of mistake.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "input/case.hpp"
#include "input/fabric.hpp"
#include "test_case_kit.hpp"
#include "test_fabric_text.hpp"
#include "test_meshes.hpp"
#include "test_relative.hpp"

namespace test_fabric_curves {

using namespace voile;
using namespace voile::testing;

namespace {

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

TEST_CASE("fabric: curves of tension and shear, and the loop of shear") {
  const std::string curved =
      replaced(replaced(fabric_text, "membrane_warp = \"2 kN/m\"\n",
                        "tension_warp = { EMT = \"4 %\", WT = \"6 gf.cm/cm^2\", LT = 0.6 }\n"),
               "membrane_shear = \"1 gf/(cm.deg)\"\n",
               "shear_curve = { units = [\"deg\", \"gf/cm\"], points = [[2, 1.2], [5, 3], [8, 6]] }\n"
               "shear_hysteresis = \"0.8 gf/cm\"\nshear_hysteresis_5 = \"1.7 gf/cm\"\n");
  const std::string text = replaced(replaced(curved, "membrane_warp = \"made up\"", "tension_warp = \"made up\""),
                                    "membrane_shear = \"made up\"",
                                    "shear_curve = \"x\"\nshear_hysteresis = \"x\"\nshear_hysteresis_5 = \"x\"");
  const input::Fabric f = input::parse_fabric(text, "f.toml");
  // E = 0.04 + 0.0008, S = 490.3325/1.04.
  REQUIRE(f.curves[0]);
  CHECK(energy::force_of(*f.curves[0], 0.0408) == relative(490.3325 / 1.04).epsilon(1e-12));
  CHECK(f.membrane_warp == f.curves[0]->tangent);
  REQUIRE(f.curves[2]);
  constexpr double degree = std::numbers::pi / 180.0, gf_per_cm = 0.980665;
  CHECK(energy::force_of(*f.curves[2], std::sin(5 * degree)) ==
        relative(3 * gf_per_cm / std::cos(5 * degree)).epsilon(1e-12));
  const energy::YarnLaw law = input::yarn_law(f, true);
  CHECK(law.stiffness == relative(0.8 * gf_per_cm / (0.5 * degree)));
  // Both branches of the loop at a strain, from the slips p with G_s (e - p) = +-(H0 + h p).
  const auto branch = [&](double e, double side) {
    const double p = (law.stiffness * e - side * law.limit) / (law.stiffness + side * law.rise);
    return law.stiffness * (e - p) + input::membrane_stiffness(f, true)(2, 2) * e +
           energy::force_of({0.0, law.knots[2]}, e);
  };
  for (const auto& [angle, width] : {std::pair{0.5, 0.8}, std::pair{5.0, 1.7}}) {
    const double e = std::sin(angle * degree), to_kes = std::cos(angle * degree) / gf_per_cm;
    CHECK((branch(e, 1.0) - branch(e, -1.0)) * to_kes == relative(width).epsilon(1e-12));
    if (angle == 5.0) CHECK(0.5 * (branch(e, 1.0) + branch(e, -1.0)) * to_kes == relative(3.0).epsilon(1e-12));
  }
  CHECK(!input::yarn_law(f, false).rubs());
  // G is the slope of the loop as it goes out: that of A66 and of the limit that grows.
  input::Fabric straight = f;
  straight.curves[2].reset();
  straight.rubbing_shear.reset();
  straight.membrane_shear = 50.0;
  CHECK(input::membrane_stiffness(straight, true)(2, 2) ==
        relative(50.0 - 1.0 / (1.0 / law.rise + 1.0 / law.stiffness)));
  CHECK(input::membrane_stiffness(straight)(2, 2) == 50.0);

  // In a case, in its units, turned, and as it is echoed.
  const FabricCase fabric_case(text);
  const std::string keys = "fabric = \"F\"\ndirection = [0, 2, 0]\nwarp_angle = 30\n";
  CHECK(!fabric_case.parse(keys).materials.at(0).yarns.rubs());
  CHECK(has(error_of([&] { (void)fabric_case.parse(keys + "prestress = [1, 1]\n"); }),
            "material.prestress: yarns that stiffen or rub"));
  const input::Case c = fabric_case.parse(keys + "hysteresis = \"friction\"\n");
  const energy::Material& m = c.materials.at(0);
  CHECK(m.friction.sliders.empty());
  CHECK(m.bending_damping ==
        fabric_case.parse(keys).materials.at(0).bending_damping);  // no loop of bending replaces it
  CHECK(m.bending_damping > 0.0);
  CHECK(m.yarns.warp_angle == relative(30.0 * degree));
  const energy::Material echoed = input::parse_case(input::echo_case(c), "case.toml").materials.at(0);
  CHECK(echoed.yarns.rise == m.yarns.rise);
  CHECK(echoed.yarns.stiffness == m.yarns.stiffness);
  CHECK(echoed.yarns.warp_angle == relative(m.yarns.warp_angle));
  for (std::size_t r = 0; r < 3; ++r) {
    REQUIRE(echoed.yarns.knots[r].size() == m.yarns.knots[r].size());
    for (std::size_t j = 0; j < m.yarns.knots[r].size(); ++j) {
      CHECK(echoed.yarns.knots[r][j].strain == m.yarns.knots[r][j].strain);
      CHECK(echoed.yarns.knots[r][j].bend == m.yarns.knots[r][j].bend);
    }
  }
}

TEST_CASE("fabric: mistakes of curves and of the loop of shear") {
  const auto tension = [](const std::string& value) {
    return error_of([&] {
      (void)input::parse_fabric(replaced(replaced(fabric_text, "membrane_warp = \"2 kN/m\"", "tension_warp = " + value),
                                         "membrane_warp = \"made", "tension_warp = \"made"),
                                "f.toml");
    });
  };
  CHECK(tension("{ EMT = \"4 %\", LT = 0.6, load = \"100 gf/cm\" }") == "no error");
  CHECK(has(tension("4"), "f.toml:4: tension_warp: a table is needed"));
  CHECK(has(tension("{ EMT = 4, LT = 0.6 }"),
            "f.toml:4: tension_warp: EMT: the unit is missing; write a text with one of %"));
  CHECK(has(tension("{ EMT = \"4 mm\", LT = 0.6 }"), "EMT: '4 mm' is a length, an extension is needed: %"));
  CHECK(has(tension("{ EMT = \"-4 %\", LT = 0.6 }"), "EMT: '-4 %' has to be greater than zero"));
  CHECK(has(tension("{ EMT = \"400 %\", LT = 0.6 }"), "EMT: 400 % is more than a fabric has"));
  CHECK(has(tension("{ EMT = \"4 %\" }"), "EMT and one of WT and LT are needed"));
  CHECK(has(tension("{ EMT = \"4 %\", WT = \"6 gf.cm/cm^2\", LT = 0.7 }"), "give LT = 0.6, not 0.7"));
  CHECK(has(tension("{ EMT = \"4 %\", LT = 0.99 }"), "LT = 0.99: a curve that stiffens smoothly needs 0.2 to 0.980"));
  CHECK(has(tension("{ EMT = \"4 %\", LT = 0.1 }"), "LT = 0.1: a curve"));
  CHECK(has(tension("{ EMT = \"4 %\", LT = 0.6, ETM = 3 }"), "unknown key 'ETM': did you mean 'EMT'?"));
  CHECK(has(tension("{ points = [[1, 2], [2, 5]] }"), "units: the units of both columns are needed"));
  CHECK(has(tension("{ units = [\"%\", \"N\"], points = [[1, 2], [2, 5]] }"), "units: '1 N' is a moment per width"));
  CHECK(has(tension("{ units = [\"%\", \"N/m\"], points = [[1, 2]] }"), "points: 2 to 12 rows are needed"));
  CHECK(has(tension("{ units = [\"%\", \"N/m\"], points = [[1, 2], [2]] }"), "points: row 2 has to be two numbers"));
  CHECK(has(tension("{ units = [\"%\", \"N/m\"], points = [[1, 2], [2, 1.9]] }"),
            "f.toml:4: tension_warp: points: row 2, [2, 1.9], does not rise from the one before, [1, 2]"));
  CHECK(has(tension("{ units = [\"%\", \"N/m\"], points = [[1, 2], [1, 3]] }"), "row 2, [1, 3], does not rise"));
  CHECK(has(tension("{ units = [\"%\", \"N/m\"], points = [[1, 100], [50, 101]] }"),
            "row 2, [50, 101]: the force grows by less than the length"));
  CHECK(has(tension("{ units = [\"%\", \"N/m\"], points = [[1, nan], [2, 3]] }"), "row 1, [1, nan], does not rise"));
  CHECK(has(tension("{ units = [\"%\", \"N/m\"], points = [[1, 2], [200, 3]] }"), "row 2: 200 is beyond 100"));
  CHECK(has(tension("{ EMT = \"4 %\", units = [\"%\", \"N/m\"], points = [[1, 2], [2, 3]] }"), "two ways"));

  const auto both = [](const std::string& more, const std::string& source) {
    return fabric_error("[sources]\n", more + "\n[sources]\n" + source + " = \"x\"\n");
  };
  CHECK(has(both("tension_warp = { EMT = \"4 %\", LT = 0.6 }", "tension_weft"), "tension_warp: the source is missing"));
  CHECK(both("tension_warp = { EMT = \"4 %\", LT = 0.6 }", "tension_warp") == "no error");
  CHECK(has(both("tension_warp = { EMT = \"40 %\", LT = 0.6 }", "tension_warp"),
            "the tangent at zero, 2000 N/m, has to lie between"));
  CHECK(has(both("shear_curve = { units = [\"deg\", \"N/m\"], points = [[1, 1], [2, 3]] }", "shear_curve"),
            "f.toml:6: membrane_shear: the points of shear_curve give this figure"));
  CHECK(has(both("shear_hysteresis_5 = 1", "shear_hysteresis_5"), "there is no shear_hysteresis (2HG)"));
  const auto loop = [&](const std::string& keys) {
    return both("shear_hysteresis = \"1 N/m\"\n" + keys, "shear_hysteresis = \"x\"\nshear_hysteresis_5 = \"x\"\n#");
  };
  CHECK(
      has(loop("shear_hysteresis_5 = 0.5"), "shear_hysteresis_5: 2HG5 = 0.5 N/m has to be 1 to 10 times 2HG = 1 N/m"));
  CHECK(has(loop("shear_hysteresis_5 = 12"), "1 to 10 times"));
  CHECK(has(loop("shear_hysteresis_5 = 6"), "the loop grows so fast"));
  CHECK(has(both("shear_hysteresis = 1\nshear_hysteresis_5 = 3\nshear_hysteresis_spread = \"8 deg\"",
                 "shear_hysteresis = \"x\"\nshear_hysteresis_5 = \"x\"\nshear_hysteresis_spread"),
            "shear_hysteresis_spread: 8 degrees: the loop is not open yet at 0.5 degrees"));
  CHECK(has(tension("{ EMT = \"0.04\", LT = 0.6 }"), "EMT: the unit of '0.04' is missing; write a text with one of %"));
  const auto matrices = [](const std::string& loop) {
    return error_of([&] {
      (void)input::parse_case(
          "[mesh]\nfile = \"a.geo\"\n[[material]]\ntype = \"matrices\"\nmembrane = [[9, 0, 0], [0, 9, 0], [0, 0, 9]]\n"
          "bending = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\ndirection = [1, 0, 0]\nshear_hysteresis = " +
              loop + "\n",
          "case.toml");
    });
  };
  CHECK(has(matrices("[0.2, 0, 0]"), "material.shear_hysteresis: the third number"));
  CHECK(has(matrices("[0.2, 0]"), "three numbers are needed"));
}

}  // namespace test_fabric_curves

// What a fit says of data that contradict each other, of instruments that are not exact, and of laws that do not hold.
#include <doctest/doctest.h>

#include <cmath>

#include "fit/heart_loop.hpp"
#include "test_fit_kit.hpp"

namespace test_fit_doubts {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::sheets;

TEST_CASE("a contradiction widens what is measured by it, and nothing else") {
  const std::string good = head +
                           "[bending_rigidity]\nwarp = \"10 +- 0.1 uN.m\"\nweft = \"8 +- 0.1 uN.m\"\n"
                           "[membrane_stiffness]\nshear = \"50 +- 1 N/m\"\n";
  const fit::Fit one = fitted("areal_density = \"200 +- 2 g/m^2\"\n" + good);
  const fit::Fit odd =
      fitted("areal_density = \"200 +- 2 g/m^2\"\n" + good + "[kes]\nB = { warp = \"13 +- 0.1 uN.m\" }\n");
  const auto deviation = [](const fit::Fit& f, Parameter p) { return f.figures.at(p).deviation; };
  for (const Parameter p : {Parameter::areal_density, Parameter::bending_weft, Parameter::membrane_shear})
    CHECK(deviation(odd, p) == relative(deviation(one, p)).epsilon(1e-6));
  CHECK(deviation(odd, Parameter::bending_warp) > 10.0 * deviation(one, Parameter::bending_warp));
  CHECK(odd.warnings.size() == 2);
  for (const char* text : {"200 g/m^2 +- 2 g/m^2", "20 mg/cm^2 +- 2 g/m^2", "200 g/m^2 +- 1 %", "200g/m^2+-1%"}) {
    CAPTURE(text);
    const fit::Fit f = fitted("areal_density = \"" + std::string(text) + "\"\n" + good);
    CHECK(value(f, Parameter::areal_density) == relative(0.2).epsilon(1e-9));
    CHECK(deviation(f, Parameter::areal_density) == relative(deviation(one, Parameter::areal_density)).epsilon(1e-9));
  }
}

TEST_CASE("an uncertainty in per cent needs the unit of the figure") {
  const auto mistake = [](const std::string& text) { return fit_error(head + "areal_density = \"" + text + "\"\n"); };
  CHECK(has(mistake("200 +- 1 %"), "the unit of '200' is missing"));
  CHECK(has(mistake("200 g/m^2 +- 2"), "the unit of ' 2' is missing"));
  CHECK(has(mistake("200 g/m^2 +- -1 %"), "greater than zero"));
  CHECK(has(mistake("+- 2 g/m^2"), "a number and a unit are needed"));
}

TEST_CASE("specimens that differ by far leave a figure open, and a warning says so") {
  const auto fabric = [&](const std::string& lengths) {
    return fitted(head + "areal_density = \"200 +- 2 g/m^2\"\n[bending_length]\nwarp = " + lengths + "\n");
  };
  CHECK(fabric("[\"20 mm\", \"20.4 mm\", \"19.6 mm\"]").warnings.empty());
  const fit::Fit open = fabric("[\"20 mm\", \"10.4 mm\", \"39.6 mm\"]");
  REQUIRE(open.warnings.size() == 1);
  CHECK(has(open.warnings[0], "bending_warp is known to +-"));
}

TEST_CASE("a heart loop and an overhang give rigidities, with the uncertainty of the strip and of the angle") {
  const double weight = 9.80665 * 0.2, strip = 0.15;
  const auto height = [&](double d) { return 1e3 * strip * fit::heart_height(weight * std::pow(strip, 3) / d); };
  const auto sheet = [&](const std::string& length) {
    return head + "areal_density = \"200 +- 0.2 g/m^2\"\n[heart_loop]\nlength = \"" + length + "\"\nwarp = \"" +
           std::to_string(height(30e-6)) + " +- 0.3 mm\"\nweft = \"" + std::to_string(height(12e-6)) + " +- 0.3 mm\"\n";
  };
  const fit::Fit exact = fitted(sheet("150 mm")), rough = fitted(sheet("150 +- 3 mm"));
  for (const fit::Fit& f : {exact, rough}) {
    CHECK(value(f, Parameter::bending_warp) == relative(30e-6).epsilon(1e-4));
    CHECK(value(f, Parameter::bending_weft) == relative(12e-6).epsilon(1e-4));
    CHECK(f.figures.size() == 3);
  }
  const double before = exact.figures.at(Parameter::bending_warp).deviation,
               after = rough.figures.at(Parameter::bending_warp).deviation;
  CHECK(after > 3.0 * before);
  const auto overhang = [&](const std::string& angle) {
    return fitted(head + "areal_density = \"200 +- 0.2 g/m^2\"\n[overhang]\nangle = \"" + angle +
                  "\"\nwarp = \"40 +- 0.1 mm\"\n")
        .figures.at(Parameter::bending_warp);
  };
  // d ln D/d angle = -d ln Gamma/d angle
  const double slope = std::log(fit::cantilever_load(42.5 * degree) / fit::cantilever_load(40.5 * degree)) / 2.0;
  CHECK(overhang("41.5 +- 1 deg").value == relative(overhang("41.5 deg").value).epsilon(1e-4));
  CHECK(std::pow(overhang("41.5 +- 1 deg").deviation, 2) - std::pow(overhang("41.5 deg").deviation, 2) ==
        relative(slope * slope).epsilon(0.02));
  CHECK(has(fit_error(head + "areal_density = \"200 g/m^2\"\n[heart_loop]\nwarp = \"60 mm\"\n"),
            "sheet.toml:4: heart_loop.length"));
  CHECK(has(fit_error(head + "areal_density = \"200 g/m^2\"\nheart_loop = \"60 mm\"\n"), "heart_loop.length"));
  CHECK(has(fit_error(head + "[heart_loop]\nlength = \"200 mm\"\nwarp = \"20 mm\"\n"),
            "sheet.toml:5: heart_loop.warp: the loop is 0.1 of the strip high"));
  CHECK(has(fit_error(head + "[heart_loop]\nlength = \"200 mm\"\nwarp = \"95 mm\"\n"), "a shorter strip"));
  CHECK(has(fit_error(head + "[heart_loop]\nlength = \"200 mm\"\nbias = \"60 mm\"\n"), "unknown name 'bias'"));
  CHECK(std::isnan(fit::heart_height(std::nan(""))));
}

TEST_CASE("a loop that does not follow the law says so") {
  const auto loop = [&](double softening) {
    std::vector<std::pair<double, double>> rows;
    const fit::Loop law = fit::bending_loop(8e-6, 4e-4, 10.0);
    const std::vector<double> strain = course(250.0, 5.0), moment = law.forces(strain, false);
    for (std::size_t i = 0; i < strain.size(); ++i)
      rows.emplace_back(strain[i], moment[i] - softening * 8e-6 * std::pow(strain[i], 3) / (250.0 * 250.0));
    const Rows file(rows);
    return fitted(head + "areal_density = \"200 g/m^2\"\n[bending_loop.warp]\nfile = \"" + file.file +
                  "\"\nunits = [\"1/m\", \"N\"]\n");
  };
  const fit::Fit good = loop(0.0), odd = loop(0.4);
  REQUIRE(good.loops.size() == 1);
  CHECK(good.loops[0].deviation < 1e-4);
  CHECK(good.warnings.empty());
  CHECK(odd.loops[0].deviation > 0.03);
  REQUIRE(odd.warnings.size() == 1);
  CHECK(has(odd.warnings[0], "bending_loop.warp: its rows deviate"));
  // 200 rows, which deviate by as much by chance, would give a twentieth.
  CHECK(odd.figures.at(Parameter::bending_warp).deviation > 0.02);
}

TEST_CASE("a bias that is softer than its yarns is named as that") {
  const std::string error = fit_error(head +
                                      "areal_density = \"200 g/m^2\"\n[bending_rigidity]\nwarp = \"20 uN.m\"\n"
                                      "weft = \"12 uN.m\"\nbias = \"7 uN.m\"\n");
  CHECK(has(error, "sheet.toml:7: bending_rigidity.bias: the strip along the bias is softer"));
  CHECK(has(error, "uN.m"));
}

}  // namespace test_fit_doubts

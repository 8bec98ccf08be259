// Sheets of known fabrics: what comes out, with which uncertainty, and what is refused.
#include "fit/fit.hpp"

#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "fit/drape_fit.hpp"
#include "fit/fabric_file.hpp"
#include "fit/least_squares.hpp"
#include "fit/record_file.hpp"
#include "input/fabric.hpp"
#include "test_fit_kit.hpp"

namespace test_fit {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::sheets;

namespace {

const std::string sheet_text = std::string(head_text) + R"toml(
areal_density = ["168 g/m^2", "170 g/m^2"]
[bending_length]
warp = ["15.0 mm", "15.4 mm", "14.8 mm"]
weft = "14.5 +- 0.3 mm"
bias = "15.5 mm"
[kes]
2HB = 0.03
G = 0.6
EMT = { warp = 4, weft = 6 }
LT = { warp = 0.6, weft = 0.55 }
RC = 40
)toml";

}  // namespace

TEST_CASE("least squares: a line, its uncertainties, and what is not seen") {
  const auto line = [](const Eigen::VectorXd& x) {
    Eigen::VectorXd r(4);
    for (int i = 0; i < 4; ++i) r[i] = x[0] + x[1] * i - (1.0 + 2.0 * i);
    return r;
  };
  const fit::LeastSquares found = fit::least_squares(line, Eigen::VectorXd::Zero(2));
  CHECK(found.unknowns[0] == relative(1.0).epsilon(1e-9));
  CHECK(found.unknowns[1] == relative(2.0).epsilon(1e-9));
  CHECK(found.null.cols() == 0);
  CHECK(found.covariance()(1, 1) == relative(0.2).epsilon(1e-6));
  CHECK(found.covariance()(0, 0) == relative(0.7).epsilon(1e-6));
  const auto sum = [](const Eigen::VectorXd& x) { return Eigen::VectorXd::Constant(1, x[0] + x[1] - 3.0); };
  CHECK(fit::least_squares(sum, Eigen::VectorXd::Zero(2)).null.cols() == 1);
  const auto lost = [](const Eigen::VectorXd& x) { return Eigen::VectorXd::Constant(2, std::log(x[0])); };
  CHECK(fit::least_squares(lost, Eigen::VectorXd::Constant(1, -1.0)).null.cols() == 1);
}

TEST_CASE("a sheet becomes a fabric file with sources, uncertainties and what was not determined") {
  const fit::Sheet sheet = fit::parse_sheet(sheet_text, "sheet.toml");
  const fit::Fit found = fit::fit_sheet(sheet, no_drape);
  const std::string text = fit::fabric_text(sheet, found);
  const input::Fabric fabric = input::parse_fabric(text, "fabric.toml");
  const double c = 1e-3 * (15.0 + 15.4 + 14.8) / 3.0;
  CHECK(fabric.areal_density == relative(0.169).epsilon(1e-5));
  CHECK(fabric.bending_warp == relative(9.81 * 0.169 * c * c * c).epsilon(1e-5));
  const double bias = 9.81 * 0.169 * std::pow(15.5e-3, 3);
  CHECK(fabric.bending_twist == relative(bias - 0.25 * (fabric.bending_warp + fabric.bending_weft)).epsilon(1e-5));
  CHECK(fabric.bending_hysteresis == relative(0.03 * 9.80665e-3).epsilon(1e-5));
  CHECK(fabric.membrane_shear == relative(0.6 * 56.18796).epsilon(1e-5));
  CHECK(fabric.curves[0]);
  // 3 s(c)/c of three specimens and s(W)/W of two, with Student's t over 1.96.
  const double of_weight = 6.483 / 169.0,
               of_length =
                   2.195 * 3.0 * std::sqrt((0.0667 * 0.0667 + 0.3333 * 0.3333 + 0.2667 * 0.2667) / 6.0) / 15.0667;
  CHECK(found.figures.at(Parameter::bending_warp).deviation ==
        relative(std::hypot(of_length, of_weight)).epsilon(1e-3));
  CHECK(found.figures.at(Parameter::bending_weft).deviation ==
        relative(std::hypot(3.0 * 0.3 / 14.5, of_weight)).epsilon(1e-3));
  CHECK(!found.figures.at(Parameter::bending_weft).assumed);
  CHECK(found.figures.at(Parameter::bending_twist).assumed);
  CHECK(found.figures.at(Parameter::areal_density).sources == std::vector<std::string>{"areal_density"});
  CHECK(has(text, "bending_length.warp"));
  CHECK(has(text, "# Not determined by the measurements"));
  for (const char* key : {"thickness", "bending_poisson", "membrane_poisson", "shear_hysteresis"})
    CHECK(has(text, std::string("#   ") + key + ":"));
  CHECK(!has(text, "#   bending_twist:"));
  CHECK(sheet.unused == std::vector<std::string>{"kes.RC"});
  CHECK(found.warnings.empty());
}

TEST_CASE("what is measured twice is weighed, and contradictions are named") {
  const fit::Fit agree = fitted(head +
                                "areal_density = \"200 g/m^2\"\n[bending_rigidity]\nwarp = \"10 +- 0.1 uN.m\"\n"
                                "[kes]\nB = { warp = \"10.4 +- 0.2 uN.m\" }\n");
  CHECK(value(agree, Parameter::bending_warp) == relative(10.08e-6).epsilon(1e-3));
  CHECK(agree.warnings.empty());
  const fit::Fit odd = fitted(head +
                              "areal_density = \"200 g/m^2\"\n[bending_rigidity]\nwarp = \"10 +- 0.1 uN.m\"\n"
                              "[kes]\nB = { warp = \"20 +- 1 uN.m\" }\n");
  REQUIRE(odd.warnings.size() == 1);
  CHECK(has(odd.warnings[0], "kes.B.warp"));
  // FAST computes B from C: it is compared, and weighs nothing.
  const fit::Fit fast =
      fitted(head + "[fast]\nW = 200\nC-1 = 18\nC-2 = 17\nB-1 = 30\nE20-1 = 1.87\nE5-1 = 0.67\nEB5 = 4.7\n");
  CHECK(value(fast, Parameter::bending_warp) == relative(9.81 * 0.2 * std::pow(18e-3, 3)).epsilon(1e-6));
  CHECK(value(fast, Parameter::membrane_warp) == relative(14.71 / 0.012).epsilon(1e-6));
  CHECK(value(fast, Parameter::membrane_shear) == relative(123.0 / 4.7).epsilon(1e-6));
  CHECK(fast.warnings.size() == 1);
}

TEST_CASE("curves of FAST, a loop of shear that narrows, one figure for both directions") {
  const std::string text =
      head + "[fast]\nW = 200\nE5-1 = 0.3\nE20-1 = 1.1\nE100-1 = 3\n[kes]\nB = 0.1\n2HG = 0.5\n2HG5 = 0.45\n";
  const fit::Sheet sheet = fit::parse_sheet(text, "sheet.toml");
  const fit::Fit found = fit::fit_sheet(sheet, no_drape);
  const std::string file = fit::fabric_text(sheet, found);
  const input::Fabric fabric = input::parse_fabric(file, "fabric.toml");
  REQUIRE(fabric.curves[0]);
  const double x = 0.03;
  CHECK(energy::force_of(*fabric.curves[0], x + 0.5 * x * x) == relative(98.0665 / (1.0 + x)).epsilon(1e-5));
  CHECK(!fabric.shear_hysteresis_5);
  REQUIRE(found.warnings.size() == 1);
  CHECK(has(found.warnings[0], "2HG5"));
  CHECK(has(file, "#   shear_hysteresis_5: the same width"));
  CHECK(has(file, "kes.B.warp (one figure for both directions)"));
  CHECK(has(file, "tension_weft = \"not measured; that of the warp\""));
}

TEST_CASE("one percent of noise on twenty specimens leaves the figures within two") {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.01);
  fit::Sheet sheet = fit::parse_sheet(sheet_text + "WC = 1\n2HG = 0.5\n2HG5 = 1.2\nT = 0.5\n", "sheet.toml");
  fit::Values truth = fit::ordinary_values();
  at(truth, Parameter::bending_weft) = 7e-6;
  at(truth, Parameter::bending_twist) = 4e-6;
  for (fit::Measurement& m : sheet.measurements) {
    const double exact = m.instrument.read(truth);
    m.figure = {0.0, 0.01 * exact / std::sqrt(20.0), 20, false};
    for (int i = 0; i < 20; ++i) m.figure.mean += exact * (1.0 + noise(random)) / 20.0;
  }
  const fit::Fit found = fit::fit_sheet(sheet, no_drape);
  for (const auto& figure : found.figures) {
    const Parameter p = figure.first;
    const auto& d = figure.second;
    CAPTURE(fit::name_of(p).key);
    // Twist is a difference of rigidities, each with three times the noise of its length.
    CHECK(d.value == relative(at(truth, p)).epsilon(p == Parameter::bending_twist ? 0.04 : 0.02));
    CHECK(std::abs(d.value / at(truth, p) - 1.0) < 3.0 * d.deviation);
  }
}

TEST_CASE("loops with noise give their figures, wherever the record begins") {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  const auto fit_of = [&](bool shear, std::size_t begin) {
    const fit::Loop loop =
        shear ? fit::shear_loop(40.0, 0.8, 2.0, 0.5 * degree) : fit::bending_loop(6.6e-6, 3.2e-4, 8.0);
    std::vector<double> x = shear ? course(8.0, 0.1) : course(250.0, 2.0), strain;
    const std::size_t once = x.size() - 1;
    for (std::size_t i = 1; i <= once; ++i) x.push_back(x[i]);
    for (const double e : x) strain.push_back(shear ? std::sin(e * degree) : e);
    const std::vector<double> f = loop.forces(strain, false);
    const double range = 2.0 * *std::max_element(f.begin(), f.end());
    std::vector<std::pair<double, double>> rows;
    for (std::size_t i = begin; i <= begin + once; ++i)
      rows.emplace_back(
          x[i], (shear ? std::cos(x[i] * degree) : 1.0) * (f[i] + (i > 0 ? 0.01 : 0.0) * range * noise(random)));
    const Rows file(rows);
    return fitted(head + "areal_density = \"160 g/m^2\"\n" +
                  (shear ? "bending_rigidity = \"6 uN.m\"\n[shear_loop]\nunits = [\"deg\", \"N/m\"]\n"
                         : "[bending_loop.warp]\nunits = [\"1/m\", \"N\"]\n") +
                  "file = \"" + file.file + "\"\n");
  };
  for (const std::size_t begin : {0, 60, 140}) {
    CAPTURE(begin);
    const fit::Fit bent = fit_of(false, begin);
    CHECK(value(bent, Parameter::bending_warp) == relative(6.6e-6).epsilon(0.02));
    // The noise is a tenth of the width of the loop.
    CHECK(value(bent, Parameter::bending_hysteresis) == relative(3.2e-4).epsilon(0.03));
    CHECK(std::abs(value(bent, Parameter::bending_hysteresis) / 3.2e-4 - 1.0) <
          3.0 * bent.figures.at(Parameter::bending_hysteresis).deviation);
    CHECK(value(bent, Parameter::bending_hysteresis_spread) == relative(8.0).epsilon(0.2));
    const fit::Fit sheared = fit_of(true, begin);
    CHECK(value(sheared, Parameter::membrane_shear) == relative(40.0).epsilon(0.02));
    CHECK(value(sheared, Parameter::shear_hysteresis) == relative(0.8).epsilon(0.15));
    CHECK(value(sheared, Parameter::shear_hysteresis_5) == relative(2.0).epsilon(0.05));
  }
}

TEST_CASE("a spread that the rows of a loop do not show is bounded or left out") {
  const auto fit_of = [](double spread, double step) {
    const fit::Loop loop = fit::bending_loop(6.6e-6, 3.2e-4, spread);
    const std::vector<double> x = course(250.0, step), f = loop.forces(x, false);
    std::vector<std::pair<double, double>> rows;
    for (std::size_t i = 0; i < x.size(); ++i) rows.emplace_back(x[i], f[i]);
    const Rows file(rows);
    return fitted(head + "areal_density = \"160 g/m^2\"\n[bending_loop.warp]\nunits = [\"1/m\", \"N\"]\nfile = \"" +
                  file.file + "\"\n");
  };
  const fit::Fit coarse = fit_of(8.0, 25.0), sharp = fit_of(1.0, 5.0);
  CHECK(!coarse.has(Parameter::bending_hysteresis_spread));
  CHECK(value(sharp, Parameter::bending_hysteresis_spread) == relative(5.0));
  CHECK(has(sharp.figures.at(Parameter::bending_hysteresis_spread).sources.at(0), "spread at most"));
  for (const fit::Fit* f : {&coarse, &sharp}) {
    CHECK(value(*f, Parameter::bending_warp) == relative(6.6e-6).epsilon(1e-3));
    CHECK(value(*f, Parameter::bending_hysteresis) == relative(3.2e-4).epsilon(2e-3));
  }
}

TEST_CASE("a loop of shear that turns within a row gives its figures, though it turns most slowly where it is widest") {
  for (const double spread : {0.05, 0.17, 0.35}) {
    const fit::Loop loop = fit::shear_loop(33.7, 0.88, 1.57, spread * degree);
    const std::vector<double> x = course(8.0, 0.4);
    std::vector<double> strain;
    for (const double e : x) strain.push_back(std::sin(e * degree));
    const std::vector<double> f = loop.forces(strain, false);
    std::vector<std::pair<double, double>> rows;
    for (std::size_t i = 0; i < x.size(); ++i) rows.emplace_back(x[i], std::cos(x[i] * degree) * f[i]);
    const Rows file(rows);
    const fit::Fit found = fitted(head + "areal_density = \"160 g/m^2\"\nbending_rigidity = \"6 uN.m\"\n" +
                                  "[shear_loop]\nunits = [\"deg\", \"N/m\"]\nfile = \"" + file.file + "\"\n");
    CHECK(value(found, Parameter::membrane_shear) == relative(33.7).epsilon(0.01));
    CHECK(value(found, Parameter::shear_hysteresis) == relative(0.88).epsilon(0.04));
    CHECK(value(found, Parameter::shear_hysteresis_5) == relative(1.57).epsilon(0.02));
  }
}

TEST_CASE("two specimens say less of their mean than twenty") {
  const fit::Fit two = fitted(head + "areal_density = [\"168 g/m^2\", \"172 g/m^2\"]\nbending_rigidity = \"6 uN.m\"\n");
  CHECK(two.figures.at(Parameter::areal_density).deviation == relative(2.0 / 170.0 * 12.706 / 1.96).epsilon(1e-3));
}

TEST_CASE("figures that no cloth has are warned of") {
  CHECK(fitted(head + "areal_density = \"160 g/m^2\"\nbending_rigidity = \"6 uN.m\"\n").warnings.empty());
  const fit::Fit heavy = fitted(head + "areal_density = \"16000 g/m^2\"\nbending_rigidity = \"6 uN.m\"\n");
  CHECK(has(heavy.warnings.at(0), "areal_density = 1.6e+04 g/m^2"));
}

TEST_CASE("a long curve with noise gives points that rise through it") {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.01);
  const auto force = [](double x) { return 20.0 * std::expm1(x / 0.0125); };  // 471 N/m at 4 %
  std::vector<std::pair<double, double>> rows;
  for (int i = 0; i <= 200; ++i) rows.emplace_back(2e-2 * i, force(2e-4 * i) + 490.0 * noise(random));
  const Rows file(rows);
  const std::string text = head +
                           "areal_density = \"160 g/m^2\"\nbending_rigidity = \"6 uN.m\"\n"
                           "[tension_curve.weft]\nunits = [\"%\", \"N/m\"]\nfile = \"" +
                           file.file + "\"\n";
  const fit::Sheet sheet = fit::parse_sheet(text, "sheet.toml");
  const fit::Fit found = fit::fit_sheet(sheet, no_drape);
  const fit::CurveFit& curve = found.curves.at("tension_weft").fit;
  CHECK(curve.points.size() == 8);
  CHECK(curve.deviation == relative(0.01).epsilon(0.15));
  for (const fit::RecordPoint& p : curve.points) CHECK(std::abs(p.force - force(p.x)) < 0.02 * 490.0);
  const input::Fabric fabric = input::parse_fabric(fit::fabric_text(sheet, found), "f.toml");
  CHECK(fabric.curves[0]);  // that of the other direction
}

TEST_CASE("a fit that the data cannot determine is refused by name") {
  const std::string bias = fit_error(head + "areal_density = \"200 g/m^2\"\n[bending_length]\nbias = \"20 mm\"\n");
  CHECK(has(bias, "sheet.toml:5: bending_length.bias: bending_warp, bending_weft, bending_twist cannot be separated"));
  CHECK(has(bias, "4 unknowns, of which the measurements see 2"));
  const std::string light = fit_error(head + "[bending_length]\nwarp = \"20 mm\"\n");
  CHECK(has(light, "areal_density, bending_warp cannot be separated"));
  CHECK(has(fit_error(head), "areal_density: it is missing"));
  CHECK(has(fit_error(head + "[kes]\nB = 0.1\n"), "areal_density: it is missing"));
  CHECK(has(fit_error(head + "[kes]\nW = 20\n"), "nothing here determines the bending stiffness"));
  CHECK(has(fit_error(head + "[kes]\nW = 20\nB = 0.1\nEMT = 5\n"), "EMT and one of WT and LT are needed"));
  for (const char* extension : {"100", "400"})
    CHECK(has(fit_error(head + "[kes]\nW = 20\nB = 0.1\nG = 0.5\nLT = 0.6\nEMT = " + extension + "\n"),
              "more than a fabric has"));
  CHECK(has(fit_error(head + "[fast]\nW = 200\nE5-1 = 50\nE20-1 = 120\n"), "more than a fabric has"));
  CHECK(has(fit_error(head + "[kes]\nW = 20\nB = 0.1\n2HG5 = 1\n"), "2HG, the loop at 0.5 degrees"));
  CHECK(has(fit_error(head + "[kes]\nW = 20\nB = 0.1\nEMT = 5\nLT = 1.3\n"), "tension_curve.warp"));
  CHECK(has(fit_error(head + "[kes]\nW = 20\nB = 0.1\nEMT = 5\nLT = 0.1\n"), "so steep an end"));
  CHECK(has(fit_error(head + "[fast]\nW = 200\nC-1 = 18\nE20-1 = 1.8\n"), "one extension alone"));
  CHECK(has(fit_error(head + "[fast]\nW = 200\nC-1 = 18\nE5-1 = 2\nE20-1 = 1.8\n"), "greater than fast.E5-1"));
}

TEST_CASE("mistakes of a sheet name line, key and remedy") {
  const auto mistake = [](const std::string& line) { return fit_error(head + line); };
  CHECK(has(mistake("areal_density = 200\n"), "sheet.toml:3: areal_density: the unit of 200 is missing"));
  CHECK(has(mistake("areal_density = \"200\"\n"), "the unit of '200' is missing"));
  CHECK(has(mistake("areal_density = \"200 mm\"\n"), "'200 mm' is a length, a mass per area is needed"));
  CHECK(has(mistake("areal_density = \"200 g/m3\"\n"), "did you mean 'g/m^2'"));
  CHECK(has(mistake("areal_density = \"-200 g/m^2\"\n"), "has to be finite and greater than zero"));
  CHECK(has(mistake("areal_density = []\n"), "the list is empty"));
  CHECK(has(mistake("areal_density = [\"200 +- 3 g/m^2\", \"210 g/m^2\"]\n"), "leave out +-"));
  CHECK(has(mistake("areal_densty = \"200 g/m^2\"\n"), "did you mean 'areal_density'"));
  CHECK(has(mistake("[kes]\nEMTT = 4\n"), "kes.EMTT: unknown name: did you mean 'EMT'"));
  CHECK(has(mistake("[bending_length]\nwrap = \"3 mm\"\n"), "did you mean 'warp'"));
  CHECK(has(mistake("[kes]\nG = { warp = 0.5 }\n"), "it has no direction"));
  CHECK(has(mistake("[bending_loop]\nfile = \"a.csv\"\n"), "[bending_loop.warp]"));
  CHECK(has(mistake("[shear_curve]\nfile = \"a.csv\"\n"), "the units of both columns are needed"));
  CHECK(has(mistake("[shear_curve]\nfile = \"a.csv\"\nunits = [\"%\", \"N/m\"]\n"), "an angle is needed"));
  CHECK(has(mistake("[shear_curve]\nfile = \"not_there.csv\"\nunits = [\"deg\", \"N/m\"]\n"), "there is no such file"));
  CHECK(has(mistake("[drape]\ncoefficient = \"140 %\"\n"), "below 100 %"));
  CHECK(has(mistake("[drape]\ncoefficient = \"40 %\"\nspecimen = \"250 mm\"\n"), "240, 300 or 360"));
  CHECK(has(error_of([] { (void)fit::parse_sheet("name = ", "s.toml"); }), "not valid TOML"));
  CHECK(has(error_of([] { (void)fit::parse_sheet("name = \"a\"\n", "s.toml"); }), "description"));
}

TEST_CASE("records that are no loops or curves are refused") {
  using Points = std::vector<fit::RecordPoint>;
  const Points loop{{0, 0}, {1, 2}, {0, 1}, {-1, -2}, {0, -1}, {0, 0}};
  CHECK(has(error_of([&] { (void)fit::require_loop(loop, "f.csv"); }), "turns the wrong way"));
  Points right(loop.rbegin(), loop.rend());
  for (fit::RecordPoint& p : right) p.x = -p.x;
  CHECK(has(error_of([&] { (void)fit::require_loop(right, "f.csv"); }), "turns the wrong way"));
  const Points good(loop.rbegin(), loop.rend());
  CHECK(fit::require_loop(good, "f.csv") > 0.0);
  CHECK(has(error_of([&] { (void)fit::require_loop({good.begin(), good.begin() + 3}, "f.csv"); }), "not closed"));
  CHECK(has(error_of([] { fit::require_curve({{0, 0}, {1, 2}, {0.5, 1}}, "f.csv"); }), "turns back at row 3"));
  const std::string file =
      (std::filesystem::temp_directory_path() / ("voile_decimal_commas_" + std::to_string(::getpid()) + ".csv"))
          .string();
  std::ofstream(file) << "x y\n1,5 20\n2,5 35\n3,5 60\n";
  CHECK(has(error_of([&] { (void)fit::read_rows(file, {1.0, 1.0}); }), "with points as decimal marks"));
  std::ofstream(file) << "x, y\n 1.5 , 20 \n2.5,35\r\n 3.5, 60\n";
  CHECK(fit::read_rows(file, {1.0, 2.0}).at(2).force == 120.0);
  std::filesystem::remove(file);
  CHECK(has(error_of([] { fit::require_curve({{0, 0}, {1, -2}}, "f.csv"); }), "positive force"));
  const Rows words({{0, 0}, {1, 1}});
  {
    std::ofstream out(words.file, std::ios::app);
    out << "2,three\n";
  }
  CHECK(has(error_of([&] { (void)fit::read_rows(words.file, {1, 1}); }), words.file + ":4: '2,three'"));
}

TEST_CASE("a drape coefficient gives the bending length of what is not measured") {
  // A tester whose coefficient grows with the mean bending length and jumps once.
  const auto tester = [](double jump) {
    return [jump](const std::string& text) {
      const input::Fabric f = input::parse_fabric(text, "f.toml");
      const double c = std::cbrt(std::sqrt(f.bending_warp * f.bending_weft) / (9.80665 * f.areal_density));
      return fit::DrapeTrial{std::clamp(30.0 * c - 0.1 + (c > 0.021 ? jump : 0.0), 0.05, 0.99), 0.0, 6.0};
    };
  };
  const std::string text = head + "areal_density = \"200 g/m^2\"\n[drape]\ncoefficient = \"60 %\"\nfolds = 5\n";
  const auto length = [](const fit::Fit& f, Parameter p) { return std::cbrt(f.figures.at(p).value / (9.80665 * 0.2)); };
  const fit::Fit both = fit::fit_sheet(fit::parse_sheet(text, "s.toml"), tester(0.0));
  CHECK(length(both, Parameter::bending_warp) == relative(0.7 / 30.0).epsilon(0.01));
  CHECK(length(both, Parameter::bending_weft) == length(both, Parameter::bending_warp));
  CHECK(both.figures.at(Parameter::bending_warp).deviation > 0.05);
  CHECK(both.comparisons.size() == 3);
  const std::string warp = text + "[bending_rigidity]\nwarp = \"20 uN.m\"\n";
  const fit::Fit weft = fit::fit_sheet(fit::parse_sheet(warp, "s.toml"), tester(0.0));
  CHECK(value(weft, Parameter::bending_warp) == relative(20e-6).epsilon(1e-6));
  CHECK(std::sqrt(20e-6 * value(weft, Parameter::bending_weft)) ==
        relative(std::pow(0.7 / 30.0, 3) * 9.80665 * 0.2).epsilon(0.03));
  const fit::Fit jumps = fit::fit_sheet(fit::parse_sheet(text, "s.toml"), tester(0.2));
  CHECK(length(jumps, Parameter::bending_warp) == relative(0.021).epsilon(0.05));
  CHECK(jumps.warnings.size() == 1);
  CHECK(has(error_of([&] { (void)fit::fit_sheet(fit::parse_sheet(replaced(text, "60", "3"), "s.toml"), tester(0.0)); }),
            "s.toml:4: drape.coefficient: 3.0 % is not reached"));
  // Where both are measured it is compared.
  const fit::Fit compared = fit::fit_sheet(fit::parse_sheet(warp + "weft = \"20 uN.m\"\n", "s.toml"), tester(0.0));
  CHECK(compared.comparisons[3].compared);
}

}  // namespace test_fit

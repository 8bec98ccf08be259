// The command line of `voile drape-test`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <tuple>

#include "base/text.hpp"
#include "drape_test.hpp"
#include "option_hint.hpp"

namespace voile::cli {

namespace {

constexpr const char* name = "drape-test";
constexpr int most_folds = 24;

/// "5" or "2..12".
std::pair<int, int> folds_of(const std::string& text) {
  const std::size_t dots = text.find("..");
  const std::string first = text.substr(0, dots), last = dots == std::string::npos ? first : text.substr(dots + 2);
  const auto number = [&](const std::string& word) {
    int n = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), n);
    if (problem != std::errc() || end != word.data() + word.size() || n < 1 || n > most_folds)
      throw UserError(fmt::format("--folds {}: a number of folds from 1 to {} is needed, or two, as 2..12",
                                  printable(text.substr(0, 40)), most_folds));
    return n;
  };
  const std::pair<int, int> folds{number(first), number(last)};
  if (folds.first > folds.second)
    throw UserError(
        fmt::format("--folds {}: the smaller number comes first; write {}..{}", text, folds.second, folds.first));
  return folds;
}

void declare(CLI::App& cli, DrapeTest& t, std::string& specimen, double& cell, std::string& folds) {
  CLI::App* c = cli.add_subcommand(name, "Measure the drape coefficient of a fabric file");
  c->footer(
      "A specimen is held between discs of 180 mm; the plate under its overhang is lowered. Friction inside the fabric "
      "acts "
      "where the file has bending_hysteresis or shear_hysteresis. Writes summary.json, contours.png and a "
      "contour_K.csv for each repeat.");
  c->add_option("fabric", t.fabric, "Fabric file, or the name of a shipped fabric")->required();
  c->add_option("--specimen", specimen, "Diameter in mm: 240, 300 or 360 [300]")
      ->check(CLI::IsMember({"240", "300", "360"}));
  c->add_option("--repeats", t.repeats,
                "Specimens, laid a millimetre beside each other, the warp turned by 15 degrees [6]")
      ->check(CLI::Range(1, 100));
  c->add_option_function<std::string>(
       "--method",
       [&t](const std::string& w) { t.method = w == "plate" ? DrapeTest::Method::plate : DrapeTest::Method::weight; },
       "plate: it is lowered; weight: without a plate the weight grows [plate]")
      ->check(CLI::IsMember({"plate", "weight"}));
  c->add_flag_callback(
      "--no-mesh-check", [&t] { t.mesh_check = false; }, "Leave out the specimen with finer cells");
  c->add_flag("--equilibria", t.equilibria,
              "Also find equilibria of the fabric without friction from several numbers of folds: equilibria.csv");
  c->add_option("--folds", folds, "With --equilibria: folds that the searches begin with, as 5 or 2..12 [2..12]");
  c->add_flag("--elastic", t.elastic, "Leave out friction inside the fabric");
  c->add_option("--cell", cell, "Edge of the cells in mm [half a bending length, 3.5 to 7]")
      ->check(CLI::Range(0.5, 20.0));
  c->add_option("--jobs", t.jobs, "Repeats side by side [one for each core]")->check(CLI::Range(1, 1000));
  c->add_option("--output", t.output, "Folder of the results [FABRIC_drape]");
  c->add_flag("--overwrite", t.overwrite, "Replace an earlier test in that folder");
  c->add_flag("--quiet", t.quiet, "Print the result only");
}

}  // namespace

bool is_drape_test(int argc, char** argv) {
  return argc > 1 && std::string(argv[1]) == name;
}

Exit drape_test_command(int argc, char** argv) {
  DrapeTest test;
  std::string specimen, folds;
  double cell = 0.0;
  CLI::App cli("Voile", "voile");
  declare(cli, test, specimen, cell, folds);
  if (!parse_command(cli, argc, argv)) return Exit::done;
  if (!specimen.empty()) test.specimen = std::stoi(specimen);
  if (!std::isfinite(cell)) throw UserError("--cell: a number of millimetres is needed");  // no range holds it
  test.cell = 1e-3 * cell;
  if (!folds.empty() && !test.equilibria) throw UserError("--folds: it needs --equilibria; add that, or leave it out");
  if (!folds.empty()) std::tie(test.least_folds, test.most_folds) = folds_of(folds);
  try {
    return run_drape_test(test);
  } catch (const StoppedBySignal&) {
    return stopped_by_signal();
  }
}

}  // namespace voile::cli

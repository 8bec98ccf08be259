// The command line of `voile drape-test`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "drape_test.hpp"
#include "option_hint.hpp"

namespace voile::cli {

namespace {

constexpr const char* name = "drape-test";

void declare(CLI::App& cli, DrapeTest& t, std::string& specimen, double& cell) {
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
  std::string specimen;
  double cell = 0.0;
  CLI::App cli("Voile", "voile");
  declare(cli, test, specimen, cell);
  if (!parse_command(cli, argc, argv)) return Exit::done;
  if (!specimen.empty()) test.specimen = std::stoi(specimen);
  if (!std::isfinite(cell)) throw UserError("--cell: a number of millimetres is needed");  // no range holds it
  test.cell = 1e-3 * cell;
  try {
    return run_drape_test(test);
  } catch (const StoppedBySignal&) {
    return stopped_by_signal();
  }
}

}  // namespace voile::cli

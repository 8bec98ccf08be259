#include "fit_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>

#include "base/plain_file.hpp"
#include "drape_files.hpp"
#include "drape_test.hpp"
#include "fit/fabric_file.hpp"
#include "fit/fit.hpp"
#include "launched_ranks.hpp"
#include "option_hint.hpp"
#include "virtual_instruments.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

constexpr const char* name = "fit";

struct FitOptions {
  std::string sheet;
  fs::path output;
  bool overwrite = false, quiet = false;
  DrapeTest drape;
  double cell = 0.0;  ///< [mm]
};

void declare(CLI::App& cli, FitOptions& o) {
  CLI::App* c = cli.add_subcommand(name, "Make a fabric file from the measurements of a laboratory");
  c->footer(
      "The measurements are a TOML file: bending lengths, sheets of KES and FAST, loops and curves as CSV, a drape "
      "coefficient; see docs/howto/fit-a-fabric.md. Prints figures, uncertainties, residuals and what the measurements "
      "do not determine.");
  c->add_option("measurements", o.sheet, "File of the measurements")->required();
  c->add_option("-o,--output", o.output, "Fabric file [MEASUREMENTS_fabric.toml]");
  c->add_flag("--overwrite", o.overwrite, "Replace that file");
  c->add_option("--repeats", o.drape.repeats, "Specimens of each virtual drape test [2]")->check(CLI::Range(1, 100));
  c->add_option_function<std::string>(
       "--method",
       [&o](const std::string& w) {
         o.drape.method = w == "plate" ? DrapeTest::Method::plate : DrapeTest::Method::weight;
       },
       "As of drape-test: plate or weight [plate]")
      ->check(CLI::IsMember({"plate", "weight"}));
  c->add_option("--cell", o.cell, "Edge of its cells in mm [half a bending length, 3.5 to 7]")
      ->check(CLI::Range(0.5, 20.0));
  c->add_option("--jobs", o.drape.jobs, "Its repeats side by side [one for each core]")->check(CLI::Range(1, 1000));
  c->add_flag("--quiet", o.quiet, "Print warnings only");
}

/// A virtual test did not come to rest.
struct NotAtRest {
  std::string message;
};

/// A folder that is removed with what is in it.
class Folder {
 public:
  Folder() {
    std::string path = (fs::temp_directory_path() / "voile_fit_XXXXXX").string();
    if (!mkdtemp(path.data())) throw UserError(fmt::format("{}: no temporary folder can be made", path));
    path_ = path;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

fit::DrapeTrial drape_trial(const FitOptions& o, int specimen, const std::string& fabric_text) {
  const Folder folder;
  DrapeTest test = o.drape;
  test.fabric = (folder.path() / "fabric.toml").string();
  test.output = folder.path();
  test.specimen = specimen;
  test.cell = 1e-3 * o.cell;
  test.quiet = true;
  std::ofstream(test.fabric) << fabric_text;
  const DrapeSetting s = drape_setting(test);
  std::vector<DrapeRepeat> repeats = drape_repeats(test.repeats);
  for (std::size_t k = 0; k < repeats.size(); ++k) {
    repeats[k].cell = s.cell;
    repeats[k].folder = folder.path() / fmt::format("repeat_{}", k + 1);
  }
  run_drape_repeats(s, repeats);
  fit::DrapeTrial trial;
  double cpu_seconds = 0.0;
  for (const DrapeRepeat& r : repeats) {
    if (!r.converged || !r.at_rest)
      throw NotAtRest{
          fmt::format("a specimen of the virtual drape test did not come to rest (bending_warp {:.3g} uN.m, "
                      "cells of {:.1f} mm); give other cells by --cell",
                      1e6 * s.fabric.bending_warp, 1e3 * s.cell)};
    trial.folds += static_cast<double>(r.shape.folds.size()) / static_cast<double>(repeats.size());
    cpu_seconds += r.cpu_seconds;
  }
  const Spread all = coefficient_of(repeats);
  trial.coefficient = 0.01 * all.mean;
  trial.deviation = 0.01 * all.deviation / std::sqrt(static_cast<double>(repeats.size()));
  if (!o.quiet) {
    fmt::print(
        "virtual drape test: bending {:.2f} and {:.2f} uN.m, coefficient {:.1f} %, {:.1f} folds ({:.0f} CPU s)\n",
        1e6 * s.fabric.bending_warp, 1e6 * s.fabric.bending_weft, all.mean, trial.folds, cpu_seconds);
    std::fflush(stdout);
  }
  return trial;
}

double bias_strip(const FitOptions& o, const std::string& fabric_text, double width) {
  const Folder folder;
  const fs::path file = folder.path() / "fabric.toml";
  std::ofstream(file) << fabric_text;
  const TestedFabric t{input::read_fabric(file), file, folder.path()};
  double part = 0.0;
  try {
    part = rigidity_read(t.fabric, overhang(t, 45, width)) / rigidity_along(t.fabric, 45);
  } catch (const UserError&) {  // names a folder that is removed
    throw NotAtRest{
        fmt::format("the virtual cantilever along the bias has failed (bending {:.3g}, {:.3g} and {:.3g} uN.m, "
                    "{:.0f} mm wide); check the measurements",
                    1e6 * t.fabric.bending_warp, 1e6 * t.fabric.bending_weft,
                    1e6 * input::bending_stiffness(t.fabric)(2, 2), 1e3 * width)};
  }
  if (!o.quiet) {
    fmt::print("virtual cantilever along the bias, {:.0f} mm wide: {:.1f} % of the rigidity of a cylinder\n",
               1e3 * width, 100.0 * part);
    std::fflush(stdout);
  }
  return part;
}

/// Nothing after the help, which was asked for.
std::optional<FitOptions> options_of(int argc, char** argv) {
  FitOptions o;
  o.drape.repeats = 2;
  CLI::App cli("Voile", "voile");
  declare(cli, o);
  if (!parse_command(cli, argc, argv)) return std::nullopt;
  if (!std::isfinite(o.cell)) throw UserError("--cell: a number of millimetres is needed");  // no range holds it
  if (o.output.empty()) o.output = fs::path(o.sheet).stem().string() + "_fabric.toml";
  return o;
}

void write_fabric(const FitOptions& o, const std::string& text) {
  require_no_link(o.output);
  std::ofstream out(o.output);
  out << text;
  if (!out.flush()) throw UserError(fmt::format("--output {}: the file cannot be written", o.output.string()));
}

}  // namespace

bool is_fit(int argc, char** argv) {
  return argc > 1 && std::string(argv[1]) == name;
}

Exit fit_command(int argc, char** argv) {
  const std::optional<FitOptions> asked = options_of(argc, argv);
  if (!asked) return Exit::done;
  const FitOptions& o = *asked;
  if (launched_rank().size > 1) throw UserError("fit: it starts its own processes; leave out mpirun, and use --jobs");
  std::error_code ignored;
  if (fs::equivalent(o.output, o.sheet, ignored))
    throw UserError(fmt::format("--output {}: that is the file of the measurements; give another", o.output.string()));
  if (fs::exists(o.output, ignored) && !o.overwrite)
    throw UserError(
        fmt::format("{}: the file is there already; give another --output, or --overwrite", o.output.string()));
  const fit::Sheet sheet = fit::read_sheet(o.sheet);
  fit::Fit fit;
  try {
    fit = fit::fit_sheet(
        sheet, [&](const std::string& text) { return drape_trial(o, sheet.drape ? sheet.drape->specimen : 300, text); },
        [&](const std::string& text, double width) { return bias_strip(o, text, width); });
  } catch (const NotAtRest& e) {
    fmt::print(stderr, "voile: not converged: {}\n", e.message);
    return Exit::not_converged;
  } catch (const StoppedBySignal&) {
    return stopped_by_signal();
  }
  write_fabric(o, fit::fabric_text(sheet, fit));
  for (const std::string& w : fit.warnings) fmt::print(stderr, "voile: warning: {}\n", w);
  if (o.quiet) return Exit::done;
  for (const std::string& line : fit::report(sheet, fit)) fmt::print("{}\n", line);
  fmt::print("fabric file {}\n", o.output.string());
  return Exit::done;
}

}  // namespace voile::cli

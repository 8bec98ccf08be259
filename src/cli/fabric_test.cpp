#include "fabric_test.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>

#include "drape_files.hpp"
#include "drape_test.hpp"
#include "fit/heart_loop.hpp"
#include "fit/instruments.hpp"
#include "fit/record_fit.hpp"
#include "launched_ranks.hpp"
#include "option_hint.hpp"
#include "virtual_instruments.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

constexpr const char* name = "fabric-test";
constexpr std::array directions{std::pair{"warp", 0}, std::pair{"weft", 90}, std::pair{"bias", 45}};

struct Options {
  std::string fabric;
  fs::path output;
  bool overwrite = false;
};

bool read_options(int argc, char** argv, Options& o) {
  CLI::App cli("Voile", "voile");
  CLI::App* c = cli.add_subcommand(name, "Measure a fabric file on virtual instruments of a laboratory");
  c->footer(
      "Cantilever along warp, weft and bias; heart loop along warp and weft; bias extension between clamps, which keep "
      "the ends from shearing, so that "
      "FAST's formula reads too stiff; loops of bending and shear where the file has friction. Writes sheet.toml, "
      "which "
      "voile fit reads, and the loops as CSV.");
  c->add_option("fabric", o.fabric, "Fabric file, or the name of a shipped fabric")->required();
  c->add_option("--output", o.output, "Folder of the results [FABRIC_test]");
  c->add_flag("--overwrite", o.overwrite, "Replace an earlier test in that folder");
  return parse_command(cli, argc, argv);
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw UserError(fmt::format("{}: cannot be written", file.string()));
}

TestedFabric tested(const Options& o) {
  DrapeTest test;
  test.fabric = o.fabric;
  const DrapeSetting s = drape_setting(test);
  TestedFabric t{s.fabric, s.fabric_file, o.output};
  if (t.folder.empty()) t.folder = s.fabric_file.stem().string() + "_test";
  t.folder = fs::absolute(t.folder).lexically_normal();
  std::error_code error;
  if (fs::exists(t.folder / "sheet.toml", error) && !o.overwrite)
    throw UserError(
        fmt::format("{}: the folder has an earlier test; give another --output, or --overwrite", t.folder.string()));
  fs::create_directories(t.folder, error);
  if (error) throw UserError(fmt::format("--output {}: the folder cannot be made", t.folder.string()));
  return t;
}

std::string record_text(const TestedFabric& t, const std::string& file,
                        const std::vector<std::pair<double, double>>& rows, const std::string& section,
                        const std::string& units) {
  std::string table = "x,force\n";
  for (const auto& [x, force] : rows) table += fmt::format("{:.9g},{:.9g}\n", x, force);
  write(t.folder / file, table);
  return fmt::format("\n[{}]\nfile = \"{}\"\nunits = [{}]\n", section, file, units);
}

void print_row(const std::string& instrument, const std::string& key, double given, double read, double si,
               const char* unit) {
  fmt::print("{:<18} {:<26} {:>11.5g} {:>11.5g} {:>+8.2f} %  {}\n", instrument, key, given / si, read / si,
             100.0 * (read / given - 1.0), unit);
  std::fflush(stdout);
}

/// Instruments one after the other: what one fails at says nothing of the others.
class Instruments {
 public:
  template <class Read>
  void run(const Read& read) {
    try {
      read();
    } catch (const InstrumentFailed& e) {
      failed_ = true;
      fmt::print(stderr, "voile: warning: {}\n", e.what());
    }
  }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  bool failed_ = false;
};

std::string hang(const TestedFabric& t, Instruments& all) {
  std::string text;
  for (const auto& [direction, angle] : directions)
    all.run([&, direction = direction, angle = angle] {
      const double length = overhang(t, angle);
      print_row(fmt::format("cantilever, {}", direction), fmt::format("rigidity along {}", direction),
                rigidity_along(t.fabric, angle), rigidity_read(t.fabric, length), 1e-6, "uN.m");
      text += fmt::format("{} = \"{:.6g} mm\"\n", direction, 1e3 * length);
    });
  return text.empty() ? text : "\n[overhang]\n" + text;
}

std::string loops(const TestedFabric& t, Instruments& all) {
  std::string text;
  for (const auto& [direction, angle] : {directions[0], directions[1]})
    all.run([&, direction = direction, angle = angle] {
      const double given = rigidity_along(t.fabric, angle), weight = fit::gravity * t.fabric.areal_density,
                   strip = heart_loop_length(t);
      if (fit::heart_height(weight * std::pow(strip, 3) / given) > fit::longest_heart)
        return fmt::print(stderr,
                          "voile: warning: heart loop, {}: left out; warp and weft are too unlike for one length\n",
                          direction);
      const HeartLoop loop = heart_loop(t, angle);
      const double length = loop.length * fit::peirce_length(loop.height / loop.length);
      print_row(fmt::format("heart loop, {}", direction), fmt::format("rigidity along {}", direction), given,
                rigidity_read(t.fabric, loop), 1e-6, "uN.m");
      print_row("", "by Peirce's formula", given, weight * std::pow(length, 3), 1e-6, "uN.m");
      if (text.empty()) text = fmt::format("\n[heart_loop]\nlength = \"{:.6g} mm\"\n", 1e3 * loop.length);
      text += fmt::format("{} = \"{:.6g} mm\"\n", direction, 1e3 * loop.height);
    });
  return text;
}

/// Figures of the fabric file by parameter.
double given_figure(const input::Fabric& f, fit::Parameter p) {
  using P = fit::Parameter;
  const Vec3 loop = f.bending_hysteresis ? input::bending_loop(f) : Vec3::Zero();
  switch (p) {
    case P::bending_warp:
      return f.bending_warp;
    case P::bending_weft:
      return f.bending_weft;
    case P::bending_hysteresis:
      return loop[0];
    case P::bending_hysteresis_weft:
      return loop[1];
    case P::membrane_shear:
      return f.membrane_shear;
    case P::shear_hysteresis:
      return f.shear_hysteresis.value_or(0.0);
    case P::shear_hysteresis_5:
      return f.shear_hysteresis_5.value_or(f.shear_hysteresis.value_or(0.0));
    default:
      return 0.0;
  }
}

void print_loops(const TestedFabric& t, const fit::Sheet& sheet) {
  for (const fit::Record& r : sheet.records)
    for (const fit::Measurement& m : fit::measurements_of(sheet, r))
      if (const double given = given_figure(t.fabric, m.instrument.parameter); given > 0.0)
        print_row(r.name, fit::name_of(m.instrument.parameter).key, given, m.figure.mean, m.si, m.unit.c_str());
}

Exit test_fabric(const TestedFabric& t) {
  fmt::print("{}\n{:<18} {:<26} {:>11} {:>11} {:>10}\n", t.fabric.name, "instrument", "figure", "in the file", "read",
             "difference");
  std::string sheet = fmt::format(
      "name = \"virtual\"\ndescription = \"Read by voile fabric-test.\"\n\nareal_density = \"{:.9g} kg/m^2\"\n",
      t.fabric.areal_density);
  Instruments all;
  sheet += hang(t, all) + loops(t, all);
  all.run([&] {
    print_row("bias, 100 x 50 mm", "shear by FAST, 123/EB5", t.fabric.membrane_shear, 1.23 / bias_extension(t), 1.0,
              "N/m");
  });
  if (t.fabric.bending_hysteresis)
    for (const auto& [direction, angle] : {directions[0], directions[1]})
      all.run([&, direction = direction, angle = angle] {
        sheet += record_text(t, fmt::format("bending_{}.csv", direction), bending_record(t, angle),
                             fmt::format("bending_loop.{}", direction), "\"1/m\", \"N\"");
      });
  if (t.fabric.shear_hysteresis && !t.fabric.curves[2])
    all.run([&] { sheet += record_text(t, "shear.csv", shear_record(t), "shear_loop", "\"deg\", \"N/m\""); });
  if (t.fabric.shear_hysteresis && t.fabric.curves[2])
    fmt::print(stderr,
               "voile: warning: shear loop: left out; the file has a shear_curve, and a loop is read by one stiffness "
               "(give shear_curve and the figures of friction to voile fit yourself)\n");
  write(t.folder / "sheet.toml", sheet);
  print_loops(t, fit::read_sheet(t.folder / "sheet.toml"));
  fmt::print("sheet for voile fit{}: {}\n", all.failed() ? ", without what has failed" : "",
             (t.folder / "sheet.toml").string());
  return all.failed() ? Exit::not_converged : Exit::done;
}

}  // namespace

bool is_fabric_test(int argc, char** argv) {
  return argc > 1 && std::string(argv[1]) == name;
}

Exit fabric_test_command(int argc, char** argv) {
  Options o;
  if (!read_options(argc, argv, o)) return Exit::done;
  if (launched_rank().size > 1) throw UserError("fabric-test: it starts its own processes; leave out mpirun");
  try {
    return test_fabric(tested(o));
  } catch (const StoppedBySignal&) {
    return stopped_by_signal();
  }
}

}  // namespace voile::cli

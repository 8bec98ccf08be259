#include "drape_test.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/plain_file.hpp"
#include "base/shipped_files.hpp"
#include "base/text.hpp"
#include "drape_equilibria.hpp"
#include "drape_files.hpp"
#include "fit/instruments.hpp"
#include "launched_ranks.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

constexpr double shift = 1e-3, turn_by = 15.0, golden_angle = 2.399963;
constexpr double largest_cell = 7e-3, smallest_cell = 3.5e-3;
/// Factor on the cells of the specimen that judges the mesh, and points of the coefficient that are too much.
constexpr double finer_cells = 0.7, most_of_mesh = 1.0;

/// A file that is there, or that of a shipped fabric.
fs::path fabric_file(const std::string& name) {
  std::error_code ignored;
  const fs::path shipped = shipped_folder("fabrics") / (name + ".toml");
  for (const fs::path& file : {fs::path(name), fs::path(name + ".toml"), shipped})
    if (fs::is_regular_file(file, ignored)) {
      require_plain_file(file);
      return fs::absolute(file).lexically_normal();
    }
  const std::string near = nearest(fs::path(name).stem().string(), shipped_names("fabrics", ".toml"));
  throw UserError(fmt::format("drape-test: there is no fabric file {} or {}{}", name, shipped.string(),
                              near.empty() ? "" : fmt::format("; did you mean {}, which is shipped?", near)));
}

void require_folder(const DrapeTest& test) {
  std::error_code error, ignored;
  if (fs::exists(test.output / "summary.json", ignored) && !test.overwrite)
    throw UserError(
        fmt::format("{}: the folder has an earlier test; give another --output, or --overwrite", test.output.string()));
  fs::create_directories(test.output, error);
  if (error || access(test.output.c_str(), W_OK) != 0)
    throw UserError(fmt::format("--output {}: the folder cannot be made or written{}", test.output.string(),
                                error ? " (" + error.message() + ")" : ""));
}

void print_repeat(const DrapeSetting& s, const DrapeRepeat& r) {
  if (s.test.quiet) return;
  const std::string text =
      fmt::format("{:>8} {:>6.0f} {:>5.0f}", r.folder.filename().string(), 1e3 * std::hypot(r.x, r.y), r.warp);
  if (!r.converged) {
    fmt::print("{}  failed: see {}\n", text, (r.folder / "run.log").string());
  } else {
    double amplitude = 0.0;
    for (const DrapeFold& f : r.shape.folds) amplitude += f.amplitude / static_cast<double>(r.shape.folds.size());
    fmt::print("{} {:>12.1f} {:>6} {:>15.1f} {:>9.1f}{}\n", text, 100.0 * r.shape.coefficient, r.shape.folds.size(),
               1e3 * amplitude, r.cpu_seconds, r.at_rest ? "" : "  still moves");
  }
  std::fflush(stdout);
}

void print_head(const DrapeSetting& s) {
  if (s.test.quiet) return;
  fmt::print("{}: specimen of {} mm, cells of {:.1f} mm, {}\n", s.fabric.name, s.test.specimen, 1e3 * s.cell,
             s.friction ? "friction inside the fabric"
             : s.test.elastic
                 ? "no friction inside the fabric"
                 : "no friction inside the fabric: the file has no bending_hysteresis or shear_hysteresis");
  fmt::print("{:>8} {:>6} {:>5} {:>12} {:>6} {:>15} {:>9}\n", "repeat", "shift", "warp", "coefficient", "folds",
             "amplitude [mm]", "CPU [s]");
}

/// What the mesh does to the coefficient, by a mesh with finer cells.
void judge_mesh(const DrapeRepeat& coarse, const DrapeRepeat& fine) {
  if (!coarse.converged || !fine.converged) return;
  const double change = 100.0 * (fine.shape.coefficient - coarse.shape.coefficient);
  fmt::print("cells of {:.1f} mm instead of {:.1f}: {:+.1f} points\n", 1e3 * fine.cell, 1e3 * coarse.cell, change);
  if (std::abs(change) > most_of_mesh)
    fmt::print(stderr, "voile: warning: the mesh changes the drape coefficient by {:.1f} points; use --cell {:.1f}\n",
               std::abs(change), 1e3 * finer_cells * fine.cell);
}

Exit conclude(const DrapeSetting& s, const std::vector<DrapeRepeat>& repeats, const std::optional<DrapeRepeat>& finer) {
  const Spread all = coefficient_of(repeats);
  std::vector<std::size_t> folds;
  std::size_t good = 0, count = repeats.size() + (finer ? 1 : 0);
  for (const DrapeRepeat& r : repeats) {
    if (r.converged) folds.push_back(r.shape.folds.size());
    good += r.converged && r.at_rest ? 1 : 0;
  }
  if (finer) good += finer->converged && finer->at_rest ? 1 : 0;
  if (finer) judge_mesh(repeats.front(), *finer);
  if (!folds.empty()) {
    const auto [least, most] = std::minmax_element(folds.begin(), folds.end());
    fmt::print("drape coefficient {:.1f} % (standard deviation {:.1f}), {} folds; results in {}\n", all.mean,
               all.deviation, *least == *most ? fmt::format("{}", *least) : fmt::format("{} to {}", *least, *most),
               s.test.output.string());
  }
  if (good == count) return Exit::done;
  fmt::print(stderr, "voile: not converged: {} of {} specimens did not come to rest; see run.log in their folders\n",
             count - good, count);
  return Exit::not_converged;
}

}  // namespace

DrapeSetting drape_setting(const DrapeTest& test) {
  DrapeSetting s;
  s.test = test;
  s.fabric_file = fabric_file(test.fabric);
  s.fabric = input::read_fabric(s.fabric_file);
  s.friction = (s.fabric.bending_hysteresis || s.fabric.shear_hysteresis) && !test.elastic;
  const double softest = std::min(s.fabric.bending_warp, s.fabric.bending_weft);
  const double length = std::cbrt(softest / (s.fabric.areal_density * fit::gravity));
  s.cell = test.cell > 0.0 ? test.cell : std::clamp(0.5 * length, smallest_cell, largest_cell);
  if (s.test.output.empty()) s.test.output = s.fabric_file.stem().string() + "_drape";
  s.test.output = fs::absolute(s.test.output).lexically_normal();
  return s;
}

void run_drape_repeats(const DrapeSetting& s, std::vector<DrapeRepeat>& repeats) {
  std::vector<CaseJob> jobs;
  for (DrapeRepeat& r : repeats)
    jobs.push_back({r.folder,
                    {},
                    [&s, &r] { write_drape_case(s, r); },
                    [&s, &r](bool success) {
                      if (success) read_drape_result(s, r);
                      print_repeat(s, r);
                    }});
  run_side_by_side(jobs, s.test.jobs);
}

std::vector<DrapeRepeat> drape_repeats(int count) {
  std::vector<DrapeRepeat> all(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    DrapeRepeat& r = all[static_cast<std::size_t>(k)];
    const double out = k == 0 ? 0.0 : shift;
    r.x = out * std::cos(k * golden_angle);
    r.y = out * std::sin(k * golden_angle);
    r.warp = turn_by * k;
  }
  return all;
}

Exit run_drape_test(const DrapeTest& test) {
  if (launched_rank().size > 1)
    throw UserError("drape-test: it starts its own processes; leave out mpirun, and use --jobs");
  const DrapeSetting s = drape_setting(test);
  require_folder(s.test);
  std::vector<DrapeRepeat> repeats = drape_repeats(test.repeats);
  for (std::size_t k = 0; k < repeats.size(); ++k) {
    repeats[k].cell = s.cell;
    repeats[k].folder = s.test.output / fmt::format("repeat_{}", k + 1);
  }
  // What takes longest begins first.
  if (test.mesh_check) {
    repeats.insert(repeats.begin(), repeats.front());
    repeats.front().cell = finer_cells * s.cell;
    repeats.front().folder = s.test.output / "finer";
  }
  print_head(s);
  run_drape_repeats(s, repeats);
  std::optional<DrapeRepeat> finer;
  if (test.mesh_check) {
    finer = std::move(repeats.front());
    repeats.erase(repeats.begin());
  }
  std::vector<DrapeEquilibrium> equilibria;
  if (test.equilibria) equilibria = find_drape_equilibria(s, repeats.front());
  write_drape_results(s, repeats, finer, equilibria);
  const Exit exit = conclude(s, repeats, finer);
  if (test.equilibria && exit == Exit::done && !has_equilibrium(equilibria)) return Exit::not_converged;
  return exit;
}

}  // namespace voile::cli

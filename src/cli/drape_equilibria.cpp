#include "drape_equilibria.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "drape_files.hpp"
#include "fit/instruments.hpp"
#include "history_read.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Residual below which a state that is not stable is an equilibrium.
constexpr double equilibrium_residual = 1e-8;
/// Part of the energy by which equilibria of one mesh differ that are the same.
constexpr double same_energy = 1e-5;

constexpr const char* search = R"(
[contact]
distance = 5e-4

[[probe]]
name = "specimen"
type = "energy"

[output]
every = 1000
fields = ["displacement"]
)";

constexpr const char* folded = R"case(
[drape]
fall = false

[[load]]
type = "area"
vector = [0, 0, -{:.9g}]
distribution = "cos({}*atan2(y, x))"
stages = ["fold"]

[[stage]]
name = "fold"
analysis = "drape"

[[stage]]
name = "hang"
analysis = "drape"
[stage.drape]
max_escapes = 0
)case";

void write_case(const DrapeSetting& s, const DrapeEquilibrium& e) {
  const std::string specimen = specimen_text(s, e.specimen, false);
  const std::string text = e.start == 0
                               ? "title = \"Equilibrium next to the drape test\"\nanalysis = \"drape\"\n\n" + specimen +
                                     search + "\n[drape]\nfall = false\nmax_escapes = 0\n"
                               : fmt::format("title = \"Equilibrium from {} folds\"\n\n", e.start) + specimen + search +
                                     fmt::format(folded, fit::gravity * s.fabric.areal_density, e.start);
  write_drape_file(e.specimen.folder / "case.toml", text);
}

double cpu_seconds_of(const fs::path& folder) {
  std::ifstream in(folder / "summary.json");
  const Json summary = in ? Json::parse(in, nullptr, false) : Json();
  return summary.is_object() ? summary.value("cpu_seconds", 0.0) : 0.0;
}

/// What a run came to, also where it has ended at an unstable equilibrium, which it says by its exit code.
void read_result(const DrapeSetting& s, DrapeEquilibrium& e) {
  const fs::path results = e.specimen.folder / "results", last = e.start == 0 ? results : results / "hang";
  e.specimen.cpu_seconds = cpu_seconds_of(last) + (e.start == 0 ? 0.0 : cpu_seconds_of(results / "fold"));
  std::error_code error;
  if (!fs::exists(last / "history.csv", error) || !fs::exists(last / "results.vtkhdf", error)) return;
  const Columns h = read_history(last / "history.csv", {"residual", "negative_pivots", "specimen_membrane",
                                                        "specimen_bending", "specimen_external"});
  if (h[0].size() < 2 || !(h[0].back() < equilibrium_residual)) return;
  e.negative_eigenvalues = std::lround(h[1].back());
  e.energy = h[2].back() + h[3].back() + h[4].back();
  std::ifstream in(last / "summary.json");
  const Json summary = Json::parse(in, nullptr, false);
  if (summary.is_object()) e.eigenvalue = summary.value("eigenvalue_nearest_to_zero", 0.0);
  read_drape_shape(s, last / "results.vtkhdf", e.specimen);
  e.specimen.converged = e.specimen.at_rest = true;
}

const char* verdict(const DrapeEquilibrium& e) {
  return e.negative_eigenvalues == 0 ? "stable" : e.negative_eigenvalues > 0 ? "unstable" : "not known";
}

void print(const DrapeSetting& s, const std::vector<DrapeEquilibrium>& all) {
  double cpu_seconds = 0.0;
  if (!s.test.quiet)
    fmt::print("equilibria of the fabric without friction\n{:>8} {:>6} {:>12} {:>12} {:>10} {:>17} {:>12} {:>8}\n",
               "from", "folds", "coefficient", "energy [mJ]", "", "eigenvalue [1/s2]", "equilibrium", "CPU [s]");
  for (const DrapeEquilibrium& e : all) {
    cpu_seconds += e.specimen.cpu_seconds;
    if (s.test.quiet) continue;
    const std::string from = e.start == 0 ? "test" : fmt::format("{}", e.start);
    if (!e.specimen.converged)
      fmt::print("{:>8}  none found: see {}\n", from, (e.specimen.folder / "run.log").string());
    else
      fmt::print("{:>8} {:>6} {:>12.1f} {:>12.5f} {:>10} {:>17.1f} {:>12} {:>8.1f}\n", from,
                 e.specimen.shape.folds.size(), 100.0 * e.specimen.shape.coefficient, 1e3 * e.energy, verdict(e),
                 e.eigenvalue, e.rank, e.specimen.cpu_seconds);
  }
  int count = 0;
  for (const DrapeEquilibrium& e : all) count = std::max(count, e.rank);
  const bool has_test = !all.empty() && all.front().start == 0 && all.front().specimen.converged;
  fmt::print("{} equilibria{}, {:.0f} CPU s\n", count,
             has_test ? fmt::format("; next to the test: number {} by energy", all.front().rank) : "", cpu_seconds);
}

}  // namespace

bool has_equilibrium(const std::vector<DrapeEquilibrium>& all) {
  return std::any_of(all.begin(), all.end(), [](const DrapeEquilibrium& e) { return e.specimen.converged; });
}

void rank_equilibria(std::vector<DrapeEquilibrium>& all) {
  std::vector<DrapeEquilibrium*> found;
  for (DrapeEquilibrium& e : all)
    if (e.specimen.converged) found.push_back(&e);
  std::sort(found.begin(), found.end(), [](const auto* a, const auto* b) { return a->energy < b->energy; });
  const DrapeEquilibrium* before = nullptr;
  for (DrapeEquilibrium* e : found) {
    const bool same = before && std::abs(e->energy - before->energy) < same_energy * std::abs(before->energy) &&
                      e->specimen.shape.folds.size() == before->specimen.shape.folds.size();
    e->rank = (before ? before->rank : 0) + (same ? 0 : 1);
    before = e;
  }
}

std::vector<DrapeEquilibrium> find_drape_equilibria(const DrapeSetting& s, const DrapeRepeat& tested) {
  std::vector<DrapeEquilibrium> all;
  for (int n = s.test.least_folds - 1; n <= s.test.most_folds; ++n) {
    DrapeEquilibrium e;
    e.start = n < s.test.least_folds ? 0 : n;
    if (e.start == 0 && !tested.converged) continue;
    e.specimen.x = tested.x;
    e.specimen.y = tested.y;
    e.specimen.warp = tested.warp;
    e.specimen.cell = tested.cell;
    e.specimen.folder =
        s.test.output / (e.start == 0 ? std::string("equilibrium_test") : fmt::format("equilibrium_{}", n));
    all.push_back(std::move(e));
  }
  std::vector<CaseJob> jobs;
  for (DrapeEquilibrium& e : all)
    jobs.push_back({e.specimen.folder, e.start == 0 ? tested.folder / "results" / "results.vtkhdf" : fs::path(),
                    [&s, &e] { write_case(s, e); }, [&s, &e](bool) { read_result(s, e); }});
  run_side_by_side(jobs, s.test.jobs);
  rank_equilibria(all);
  print(s, all);
  return all;
}

Json write_equilibria(const fs::path& file, const std::vector<DrapeEquilibrium>& all) {
  Json list = Json::array();
  std::string table =
      "start_folds,folds,drape_coefficient,energy_mJ,negative_eigenvalues,eigenvalue_nearest_to_zero,equilibrium,"
      "cpu_seconds\n";
  for (const DrapeEquilibrium& e : all) {
    const bool found = e.specimen.converged;
    const auto cell = [&](const std::string& text) { return found ? text : std::string(); };
    const std::size_t folds = e.specimen.shape.folds.size();
    const double coefficient = 100.0 * e.specimen.shape.coefficient;
    table +=
        fmt::format("{},{},{},{},{},{},{},{:.2f}\n", e.start == 0 ? "test" : fmt::format("{}", e.start),
                    cell(fmt::format("{}", folds)), cell(fmt::format("{:.4f}", coefficient)),
                    cell(fmt::format("{:.9g}", 1e3 * e.energy)), cell(fmt::format("{}", e.negative_eigenvalues)),
                    cell(fmt::format("{:.6g}", e.eigenvalue)), cell(fmt::format("{}", e.rank)), e.specimen.cpu_seconds);
    Json one{{"start", e.start == 0 ? Json("test") : Json(e.start)}, {"found", found}};
    if (found)
      one.update({{"fold_count", folds},
                  {"drape_coefficient", coefficient},
                  {"energy_mJ", 1e3 * e.energy},
                  {"stable", e.negative_eigenvalues < 0 ? Json() : Json(e.negative_eigenvalues == 0)},
                  {"negative_eigenvalues", e.negative_eigenvalues},
                  {"eigenvalue_nearest_to_zero", e.eigenvalue},
                  {"equilibrium", e.rank}});
    one["cpu_seconds"] = e.specimen.cpu_seconds;
    list.push_back(one);
  }
  write_drape_file(file, table);
  return list;
}

}  // namespace voile::cli

#include "compare_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <string>

#include "base/frequency_unit.hpp"
#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "launched_ranks.hpp"
#include "mode_comparison.hpp"
#include "option_hint.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

constexpr const char* name = "compare";

struct CompareOptions {
  std::string first, second;
  fs::path output;
  bool overwrite = false;
  double near = 0.01;
};

void declare(CLI::App& cli, CompareOptions& o) {
  CLI::App* c = cli.add_subcommand(name, "Find which modes of two runs are the same");
  c->footer(
      "Each run is the output folder of an analysis \"modal\" or \"buckling\". MAC is the modal assurance criterion, 1 "
      "for "
      "the same mode; of modes with nearly one value, `span` is how much of the mode lies in all of them.");
  c->add_option("first", o.first, "Output folder of a run")->required();
  c->add_option("second", o.second, "Output folder of the other one")->required();
  c->add_option("--near", o.near, "Values that differ by no more than this fraction count as one [0.01]")
      ->check(CLI::Range(0.0, 1.0));
  c->add_option("-o,--output", o.output, "Table of all MAC (CSV)");
  c->add_flag("--overwrite", o.overwrite, "Replace that file");
}

std::string unit_of(const ModeSet& set) {
  const std::string unit = frequency_unit(set.quantity);
  return unit.empty() ? "" : "[" + unit + "]";
}

void print(const ModeSet& first, const ModeSet& second, const ModeComparison& c) {
  fmt::print("{}\n", c.by_mass ? "modes weighted by the mass"
                     : c.same_mesh
                         ? "modes without masses"
                         : "meshes differ: modes of the finer one at the vertices of the other, without masses");
  fmt::print("{:>6} {:>14} {:>8} {:>14} {:>10} {:>8} {:>8}\n", "first", unit_of(first), "second", unit_of(second),
             "differ [%]", "MAC", "span");
  for (std::size_t i = 0; i < c.partners.size(); ++i) {
    const Partner& p = c.partners[i];
    const double one = first.values[i], other = second.values[p.best];
    fmt::print("{:>6} {:>14.6g} {:>8} {:>14.6g} {:>10.3g} {:>8.4f}", i + 1, one, p.best + 1, other,
               100.0 * (other - one) / one, c.mac(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(p.best)));
    std::vector<std::size_t> numbers;
    for (const std::size_t j : p.around) numbers.push_back(j + 1);
    if (numbers.size() > 1) fmt::print(" {:>8.4f} of {}", p.span, join(numbers, ", "));
    fmt::print("\n");
  }
}

void write(const fs::path& file, const ModeComparison& c) {
  require_no_link(file);
  std::ofstream out(file);
  out << "mode";
  for (Eigen::Index j = 0; j < c.mac.cols(); ++j) out << ',' << j + 1;
  out << ",best,span\n";
  for (Eigen::Index i = 0; i < c.mac.rows(); ++i) {
    const Partner& p = c.partners[static_cast<std::size_t>(i)];
    out << i + 1;
    for (Eigen::Index j = 0; j < c.mac.cols(); ++j) out << fmt::format(",{:.17g}", c.mac(i, j));
    out << fmt::format(",{},{:.17g}\n", p.best + 1, p.span);
  }
  if (!out.flush()) throw UserError(fmt::format("--output {}: the file cannot be written", file.string()));
}

}  // namespace

bool is_compare(int argc, char** argv) {
  return argc > 1 && std::string(argv[1]) == name;
}

Exit compare_command(int argc, char** argv) {
  CompareOptions o;
  CLI::App cli("Voile", "voile");
  declare(cli, o);
  if (!parse_command(cli, argc, argv)) return Exit::done;
  if (launched_rank().size > 1) throw UserError("compare: one process reads both runs; leave out mpirun");
  std::error_code ignored;
  if (!o.output.empty() && fs::exists(o.output, ignored) && !o.overwrite)
    throw UserError(
        fmt::format("{}: the file is there already; give another --output, or --overwrite", o.output.string()));
  const ModeSet first = read_modes(o.first), second = read_modes(o.second);
  if (first.quantity != second.quantity)
    throw UserError(fmt::format("{} has {}, and {} has {}; compare runs of one analysis", o.first, first.quantity,
                                o.second, second.quantity));
  const ModeComparison c = compare(first, second, o.near);
  print(first, second, c);
  if (!o.output.empty()) write(o.output, c);
  return Exit::done;
}

}  // namespace voile::cli

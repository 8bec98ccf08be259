#include "modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/frequency_unit.hpp"
#include "base/interrupt.hpp"
#include "base/mpi.hpp"
#include "excitation.hpp"
#include "harmonic.hpp"
#include "record/mode_error.hpp"
#include "record/response.hpp"
#include "record/validity.hpp"
#include "results/results.hpp"
#include "solve/eigen.hpp"
#include "system/rigid_motions.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

void warn_of_errors(const input::Case& c, const record::Summary& s) {
  const bool vibration = c.vibrates();
  std::string found;
  double largest = 0.0;
  for (std::size_t i = 0; i < s.mode_errors.size(); ++i) {
    if (!(s.mode_errors[i] > record::error_limit) || !record::counts(c, s.eigen, i)) continue;
    found += fmt::format("{}{}", found.empty() ? "" : ", ", i + 1);
    largest = std::max(largest, s.mode_errors[i]);
  }
  if (found.empty()) return;
  fmt::print(
      stderr,
      "voile: warning: cells do not resolve mode(s) {}: {} may be wrong by about {:.2g} %; use cells {:.1f} times "
      "smaller where they bend (summary.json: eigenvalue_errors)\n",
      found, vibration ? "their frequencies" : "their load factors", 100.0 * std::min(largest, 0.99),
      std::max(1.1, std::sqrt(largest / record::error_limit)));
}

/// Columns of modes.csv that modes of vibration have besides.
std::vector<std::string> participation_columns() {
  std::vector<std::string> names{"modal_mass"};
  for (const char* quantity : {"participation_", "effective_mass_", "effective_inertia_"})
    for (const char* axis : {"x", "y", "z"}) names.push_back(std::string(quantity) + axis);
  return names;
}

std::vector<double> participation_values(const solve::Participation& p) {
  std::vector<double> values{p.mass};
  values.insert(values.end(), p.factor.begin(), p.factor.begin() + 3);
  values.insert(values.end(), p.effective.begin(), p.effective.end());
  return values;
}

/// How much of the mass the modes move, in each direction.
std::string carried_text(const std::vector<solve::Participation>& all, double mass) {
  std::array<double, 3> sum{};
  for (const solve::Participation& p : all)
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += p.effective[k];
  const auto percent = [&](std::size_t k) { return fmt::format("{:.1f} %", 100.0 * sum[k] / mass); };
  return fmt::format("the first {} carr{} {} of the mass in x, {} in y, {} in z",
                     all.size() == 1 ? "mode" : fmt::format("{} modes", all.size()), all.size() == 1 ? "ies" : "y",
                     percent(0), percent(1), percent(2));
}

struct Estimated {  ///< of each mode
  const std::vector<double>& errors;
  const std::vector<solve::Participation>& parts;  ///< empty: of buckling
  Mat mass;                                        ///< likewise null
};

/// Of a mode, for scalar products; empty without masses, and where rigid bodies have some of their own.
std::vector<double> times_mass(const system::Model& model, Mat mass, Vec shape) {
  if (!mass || !model.dofs().motions().empty()) return {};
  const petsc::VecHandle product = model.dofs().create_vector();
  VOILE_PETSC(MatMult(mass, shape, product));
  model.dofs().clear_fixed(product);
  return model.dofs().gather_forces(product);
}

/// Returns the shapes that a later stage needs and no file keeps, on rank 0.
std::vector<std::vector<double>> write_modes(const input::Case& c, const record::RunOptions& options,
                                             const system::Model& model, const solve::EigenResult& result,
                                             const Estimated& of) {
  std::vector<std::vector<double>> kept;
  const bool vibration = c.vibrates();
  const input::UnitSystem units(c.units);
  std::optional<results::ResultsWriter> fields;
  std::optional<results::HistoryWriter> table;
  mpi::on_root(model.dofs().comm(), [&] {
    if (options.output.empty()) return;
    const mesh::Partition& p = model.dofs().partition();
    fields.emplace(options.output / "modes", results::ObstacleTriangles{}, units.label("m"));
    fields->begin_epoch(model.dofs().mesh(), p.vertex_rank, p.triangle_rank);
    std::vector<std::string> columns{"mode", vibration ? frequency_column(c.units.time) : "critical_load_factor",
                                     "eigenvalue", "residual", "estimated_error"};
    for (std::string& name : vibration ? participation_columns() : std::vector<std::string>{})
      columns.push_back(std::move(name));
    table.emplace(options.output / "modes.csv", columns);
  });
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const solve::Mode& mode = result.modes[i];
    std::vector<double> shape = model.dofs().gather_change(mode.shape);
    const std::vector<double> weighted = times_mass(model, of.mass, mode.shape);
    mpi::on_root(model.dofs().comm(), [&] {
      const int number = static_cast<int>(i) + 1;
      std::vector<double> row{static_cast<double>(number), mode.value, mode.eigenvalue, mode.residual, of.errors[i]};
      for (const double x : vibration ? participation_values(of.parts[i]) : std::vector<double>{}) row.push_back(x);
      if (table) table->write(row);
      if (c.stage.gives_modes && !fields) kept.push_back(shape);
      results::StepFields step{number, static_cast<double>(number), model.conditions().load_factor(), {}};
      step.fields.push_back({"mode", "1", results::Centre::vertex, 3, std::move(shape)});
      if (!weighted.empty())
        step.fields.push_back({"mode_times_mass", units.label("kg"), results::Centre::vertex, 3, weighted});
      if (fields) fields->write(step);
      if (options.verbosity != record::Verbosity::quiet)
        fmt::print("{:>5} {:>16.8g} {:>12.2e} {:>14.2g}\n", number, mode.value, mode.residual, 100.0 * of.errors[i]);
    });
  }
  mpi::on_root(model.dofs().comm(), [&] {
    if (fields) fields->finish();
  });
  return kept;
}

/// How many modes an analysis looks for at first where the case does not say, and at most.
constexpr int first_modes = 10, most_modes = 640;

/// Modes of vibration, as many as the case says or the highest frequency of its response needs.
VibrationModes find_vibration(const input::Case& c, system::Model& model, Vec a) {
  const bool direct =
      c.analysis == input::Analysis::harmonic && c.harmonic.method == input::HarmonicSection::Method::direct;
  VibrationModes found{solve::MassMatrix(model, a, c.eigen.mass), system::rigid_inertia(model, a, c.eigen.mass), {}};
  if (c.eigen.modes > 0) found.result = solve::vibration_modes(model, a, c.eigen.modes, found.mass.mat());
  if (c.eigen.modes > 0 || direct) return found;
  const double needed = mode_margin * record::highest_frequency(c.harmonic);
  for (int count = first_modes;; count *= 2) {
    found.result = solve::vibration_modes(model, a, count, found.mass.mat());
    const std::vector<solve::Mode>& modes = found.result.modes;
    if (found.result.asked_for != count) return found;  // by -eps_nev
    if (static_cast<int>(modes.size()) < found.result.asked_for || modes.back().value >= needed) return found;
    if (SignalScope::stop_asked(model.dofs().comm())) return found;
    if (count >= most_modes)
      throw UserError(
          fmt::format("{}: harmonic.to: more than {} modes lie below {:.4g} Hz; lower it, give eigen.modes, "
                      "or method = \"direct\"",
                      c.file.string(), count, needed));
  }
}

/// Beyond it a critical load of linear buckling is not that of the path.
constexpr double most_nonlinearity = 0.1;

/// What modes of vibration have besides; of buckling nothing.
struct Vibration {
  std::vector<solve::Participation> parts;
  Mat mass = nullptr;
};

/// Estimates, table and summary of the modes.
void report_modes(const input::Case& c, const record::RunOptions& options, system::Model& model, Vec a,
                  const solve::EigenResult& result, const Vibration& of, record::Summary& summary) {
  const bool vibration = c.vibrates(), root = mpi::rank(model.dofs().comm()) == 0;
  if (root && options.verbosity != record::Verbosity::quiet)
    fmt::print("{:>5} {:>16} {:>12} {:>14}\n", "mode", vibration ? "frequency [Hz]" : "load factor", "residual",
               "est. error [%]");
  for (const solve::Mode& mode : result.modes) summary.eigen.push_back(mode.value);
  record::ModeErrors errors =
      vibration ? record::ModeErrors(model, a, c.eigen.mass) : record::ModeErrors(model, a, result.response);
  const std::vector<char> rigid = rigid_modes(c, model, result.modes);
  for (std::size_t i = 0; i < rigid.size(); ++i) {
    double error = errors.of(result.modes[i]);
    if (vibration) error *= rigid[i] != 0 ? 0.0 : 0.5;  // of the square of the frequency
    summary.mode_errors.push_back(error);
  }
  summary.mode_shapes = write_modes(c, options, model, result, {summary.mode_errors, of.parts, of.mass});
  if (root) warn_of_errors(c, summary);
  if (root && result.lower > 0)
    fmt::print(stderr, "voile: warning: {} mode(s) lie below those listed, which are the nearest to -eps_target\n",
               result.lower);
  if (const auto growing = std::count_if(result.modes.begin(), result.modes.end(), solve::is_complex);
      root && growing > 0)
    fmt::print(stderr,
               "voile: warning: {} mode(s) are complex: with loads that turn with the sheet two have become one, which "
               "grows (flutter); their frequencies are those of the real parts; follow the motion with analysis = "
               "\"dynamic\"\n",
               growing);
  long growing = result.negative;  // not known with loads that turn with the sheet
  if (vibration) {
    long slow = 0;
    for (std::size_t i = 0; i < rigid.size(); ++i) slow += rigid[i] == 0 && result.modes[i].value < 0.0 ? 1 : 0;
    growing = std::max(growing, slow);
  }
  if (root && growing > 0)
    fmt::print(stderr,
               "voile: warning: the equilibrium is unstable: {}{} mode(s) grow, and have their rate as a negative "
               "frequency\n",
               growing > result.negative ? "at least " : "", growing);
  if (root && !(result.nonlinearity <= most_nonlinearity))
    fmt::print(
        stderr,
        "voile: warning: up to mode 1 the sheet deflects {} out of proportion to its load; the load of its path may "
        "differ about as much from that of the mode; choose a larger eigen.load_factor, or follow the path "
        "(analysis = \"static\", control = \"arc_length\")\n",
        result.nonlinearity < 1.0 ? fmt::format("by {:.2g} %", 100.0 * result.nonlinearity) : "by more than 100 %");
  summary.converged = static_cast<int>(result.modes.size()) >= result.asked_for;
  if (!summary.converged)
    summary.reason = fmt::format("{} of {} modes found{}", result.modes.size(), result.asked_for,
                                 vibration ? "" : " (a load can have fewer critical factors)");
  if (result.missed > 0) {
    summary.converged = false;
    summary.reason =
        fmt::format("{} mode(s) before the last one have not been found; ask for more by eigen.modes", result.missed);
  }
  if (SignalScope::stop_asked(model.dofs().comm())) {
    summary.converged = false;
    summary.reason =
        fmt::format("{}; {} of {} modes had been found", Interrupted().what(), result.modes.size(), result.asked_for);
  }
}

}  // namespace

std::vector<char> rigid_modes(const input::Case& c, const system::Model& model, const std::vector<solve::Mode>& modes) {
  constexpr double noise = 3e-5;  // of frequencies: the root of the round-off of their squares
  constexpr double small = 1e-2;  // of the first mode that strains, where the supports leave free motions
  std::size_t free = 0;
  for (const system::FreePiece& piece :
       system::free_pieces(model.dofs().mesh(), model.discretisation().constraints(), c.springs))
    free += static_cast<std::size_t>(piece.motions());
  std::vector<char> rigid;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    double limit = noise * std::abs(modes.back().value);
    if (i < free && free < modes.size()) limit = std::max(limit, small * std::abs(modes[free].value));
    rigid.push_back(std::abs(modes[i].value) < limit ? 1 : 0);
  }
  return rigid;
}

void run_modes(const input::Case& c, const record::RunOptions& options, system::Model& model, Vec a,
               record::Summary& summary) {
  if (!c.vibrates()) {
    require_straight(c, model.dofs().mesh());
    solve::Newton newton(model);
    return report_modes(c, options, model, a, solve::buckling_modes(newton, model, a, c.eigen.modes), {}, summary);
  }
  require_excitation(c, model);
  const VibrationModes found = find_vibration(c, model, a);
  if (found.result.asked_for > 0) {
    const auto parts = solve::participation(found.result.modes, found.mass.mat(), found.inertia);
    report_modes(c, options, model, a, found.result, {parts, found.mass.mat()}, summary);
    if (!parts.empty() && mpi::rank(model.dofs().comm()) == 0 && options.verbosity != record::Verbosity::quiet)
      fmt::print("{}\n", carried_text(parts, found.inertia.mass));
  }
  if (c.analysis == input::Analysis::harmonic && summary.converged) run_harmonic(c, options, model, a, found, summary);
}

}  // namespace voile::simulation

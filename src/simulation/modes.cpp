#include "modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/interrupt.hpp"
#include "base/mpi.hpp"
#include "io/results.hpp"
#include "record/discretisation_error.hpp"
#include "record/linear_values.hpp"
#include "record/validity.hpp"
#include "solve/eigen.hpp"

namespace voile::simulation {

namespace {

/// Relative error of an eigenvalue by recovery: the energy by which the stress resultants of its mode differ from smooth ones,
/// over the energy that the eigenvalue is a quotient of; on rank 0. Collective.
double error_of(system::Model& model, Vec a, const solve::Mode& mode, bool vibration,
                record::DiscretisationError& recovery) {
  record::LinearValues change(model, mode.shape, a);
  const system::TriangleFields fields = change.triangle_changes();
  const double whole = 0.5 * change.stiffness();
  const record::DiscretisationError::Densities error = recovery.of(model, fields);
  if (mpi::rank(model.dofs().comm()) != 0) return 0.0;
  const energy::Sheet& sheet = model.discretisation().sheet();
  double sum = 0.0;
  for (std::size_t t = 0; t < error.membrane.size(); ++t)
    sum += sheet.mesh().area(static_cast<Index>(t)) * (error.membrane[t] + error.bending[t]);
  const double energy = vibration ? whole : record::stored_energy(sheet, fields);
  return energy > 0.0 ? sum / energy : std::nan("");
}

/// Rigid motions have no energy to be wrong.
bool is_rigid(double value, const std::vector<double>& values) {
  constexpr double noise = 3e-5;  // of frequencies: the root of the round-off of their squares
  return std::abs(value) < noise * std::abs(values.back());
}

void warn_of_errors(const record::Summary& s, bool vibration) {
  std::string found;
  double largest = 0.0;
  for (std::size_t i = 0; i < s.mode_errors.size(); ++i) {
    if (!(s.mode_errors[i] > record::error_limit)) continue;
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

void write_modes(const input::Case& c, const record::RunOptions& options, const system::Model& model,
                 const solve::EigenResult& result, const std::vector<double>& errors) {
  const bool vibration = c.analysis == "modal";
  std::optional<io::ResultsWriter> fields;
  std::optional<io::HistoryWriter> table;
  mpi::on_root(model.dofs().comm(), [&] {
    if (options.output.empty()) return;
    const mesh::Partition& p = model.dofs().partition();
    fields.emplace(options.output / "modes");
    fields->begin_epoch(model.dofs().mesh(), p.vertex_rank, p.triangle_rank);
    table.emplace(options.output / "modes.csv",
                  std::vector<std::string>{"mode", vibration ? "frequency_hz" : "critical_load_factor", "eigenvalue",
                                           "residual", "estimated_error"});
  });
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const solve::Mode& mode = result.modes[i];
    std::vector<double> shape = model.dofs().gather_change(mode.shape);
    mpi::on_root(model.dofs().comm(), [&] {
      const int number = static_cast<int>(i) + 1;
      if (table) table->write({static_cast<double>(number), mode.value, mode.eigenvalue, mode.residual, errors[i]});
      io::StepFields step{number, static_cast<double>(number), model.conditions().load_factor(), {}};
      step.fields.push_back({"mode", "1", io::Centre::vertex, 3, std::move(shape)});
      if (fields) fields->write(step);
      if (options.verbosity != record::Verbosity::quiet)
        fmt::print("{:>5} {:>16.8g} {:>12.2e} {:>14.2g}\n", number, mode.value, mode.residual, 100.0 * errors[i]);
    });
  }
  mpi::on_root(model.dofs().comm(), [&] {
    if (fields) fields->finish();
  });
}

}  // namespace

void run_modes(const input::Case& c, const record::RunOptions& options, system::Model& model, Vec a,
               record::Summary& summary) {
  const bool vibration = c.analysis == "modal", root = mpi::rank(model.dofs().comm()) == 0;
  const auto find = [&] {
    if (vibration) return solve::vibration_modes(model, a, c.eigen.modes, c.eigen.mass);
    solve::Newton newton(model);
    return solve::buckling_modes(newton, model, a, c.eigen.modes);
  };
  const solve::EigenResult result = find();
  if (root && options.verbosity != record::Verbosity::quiet)
    fmt::print("{:>5} {:>16} {:>12} {:>14}\n", "mode", vibration ? "frequency [Hz]" : "load factor", "residual",
               "est. error [%]");
  for (const solve::Mode& mode : result.modes) summary.eigen.push_back(mode.value);
  record::DiscretisationError recovery;
  for (const solve::Mode& mode : result.modes) {
    double error = error_of(model, a, mode, vibration, recovery);
    if (vibration) error *= is_rigid(mode.value, summary.eigen) ? 0.0 : 0.5;  // of the square of the frequency
    summary.mode_errors.push_back(error);
  }
  write_modes(c, options, model, result, summary.mode_errors);
  if (root) warn_of_errors(summary, vibration);
  summary.converged = static_cast<int>(result.modes.size()) >= result.asked_for;
  if (!summary.converged)
    summary.reason = fmt::format("{} of {} modes found{}", result.modes.size(), result.asked_for,
                                 vibration ? "" : " (a load can have fewer critical factors)");
  if (SignalScope::stop_asked(model.dofs().comm())) {
    summary.converged = false;
    summary.reason =
        fmt::format("{}; {} of {} modes had been found", Interrupted().what(), result.modes.size(), result.asked_for);
  }
}

}  // namespace voile::simulation

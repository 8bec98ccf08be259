#include "modes.hpp"

#include <fmt/format.h>

#include <optional>

#include "voile/base/interrupt.hpp"
#include "voile/base/mpi.hpp"
#include "voile/io/results.hpp"
#include "voile/solve/eigen.hpp"

namespace voile::app {

namespace {

void write_modes(const input::Case& c, const RunOptions& options, const system::Model& model,
                 const solve::EigenResult& result) {
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
                                           "residual"});
  });
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const solve::Mode& mode = result.modes[i];
    std::vector<double> shape = model.dofs().gather(mode.shape);
    mpi::on_root(model.dofs().comm(), [&] {
      const int number = static_cast<int>(i) + 1;
      if (table) table->write({static_cast<double>(number), mode.value, mode.eigenvalue, mode.residual});
      io::StepFields step{number, static_cast<double>(number), model.conditions().load_factor(), {}};
      step.fields.push_back({"mode", "1", io::Centre::vertex, 3, std::move(shape)});
      if (fields) fields->write(step);
      if (options.verbosity != Verbosity::quiet)
        fmt::print("{:>5} {:>16.8g} {:>12.2e}\n", number, mode.value, mode.residual);
    });
  }
  mpi::on_root(model.dofs().comm(), [&] {
    if (fields) fields->finish();
  });
}

}  // namespace

void run_modes(const input::Case& c, const RunOptions& options, system::Model& model, Vec a, Summary& summary) {
  const bool vibration = c.analysis == "modal", root = mpi::rank(model.dofs().comm()) == 0;
  const auto find = [&] {
    if (vibration) return solve::vibration_modes(model, a, c.eigen.modes, c.eigen.mass);
    solve::Newton newton(model);
    return solve::buckling_modes(newton, model, a, c.eigen.modes);
  };
  const solve::EigenResult result = find();
  if (root && options.verbosity != Verbosity::quiet)
    fmt::print("{:>5} {:>16} {:>12}\n", "mode", vibration ? "frequency [Hz]" : "load factor", "residual");
  write_modes(c, options, model, result);
  for (const solve::Mode& mode : result.modes) summary.eigen.push_back(mode.value);
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

}  // namespace voile::app

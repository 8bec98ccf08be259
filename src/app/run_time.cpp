#include "run_time.hpp"
#include "obstacles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>
#include <utility>

#include "signals.hpp"
#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"
#include "voile/io/checkpoint.hpp"
#include "voile/solve/time_integration.hpp"

namespace voile::app {

namespace {

using Clock = std::chrono::steady_clock;

/// A state between models: global axes, mesh order, on rank 0.
using Carried = io::Checkpoint;

Carried carry(const solve::TimeReport& r, const system::Model& model) {
  Carried c{r.state.step,
            r.state.time,
            r.state.next_step,
            model.gather(r.state.position),
            model.gather(r.state.velocity),
            {}};
  if (r.state.acceleration) c.acceleration = model.gather(r.state.acceleration);
  return c;
}

/// Unknowns of one model.
struct State {
  petsc::VecHandle u, v, a;

  State(const Carried& from, const system::Model& model)
      : u(model.create_vector()), v(model.create_vector()), a(model.create_vector()) {
    scatter(from.displacement, u, model);
    scatter(from.velocity, v, model);
    scatter(from.acceleration, a, model);
  }
  static void scatter(std::vector<double> values, Vec to, const system::Model& model) {
    values.resize(static_cast<std::size_t>(model.unknowns()), 0.0);  // nothing given: zero
    model.scatter(values, to);
  }
};

/// Writes checkpoints when they are due or asked for.
class Checkpoints {
 public:
  Checkpoints(const Case& c, const RunOptions& options, const mesh::SurfaceMesh& mesh)
      : section_(c.time), file_(options.output / "checkpoint.h5"), mesh_(mesh) {}

  /// True if the run shall stop. Collective.
  bool after_step(const solve::TimeReport& r, const system::Model& model) {
    const Requests asked = SignalScope::take();
    const double minutes = std::chrono::duration<double>(Clock::now() - last_).count() / 60.0;
    const bool by_time = section_.checkpoint_minutes > 0.0 && minutes >= section_.checkpoint_minutes;
    const bool by_step = section_.checkpoint_steps > 0 && r.state.step % section_.checkpoint_steps == 0;
    const bool due = mpi::max(model.comm(), by_time ? 1.0 : 0.0) > 0.0;  // clocks differ between ranks
    if (due || by_step || asked.checkpoint) write(r, model);
    return asked.stop;
  }
  void write(const solve::TimeReport& r, const system::Model& model) {
    const Carried c = carry(r, model);
    mpi::on_root(model.comm(), [&] { io::write_checkpoint(file_, c, mesh_); });
    last_ = Clock::now();
  }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  const TimeSection& section_;
  std::filesystem::path file_;
  const mesh::SurfaceMesh& mesh_;
  Clock::time_point last_ = Clock::now();
};

/// Times within the run at which a support lets go, and its end.
std::vector<double> epoch_ends(const Case& c, double start) {
  std::set<double> ends{c.time.options.end_time};
  for (const system::Support& s : c.supports)
    if (s.release > start && s.release < c.time.options.end_time) ends.insert(s.release);
  return {ends.begin(), ends.end()};
}

/// Supports that still hold after time t.
std::vector<system::Support> holding(const Case& c, double t) {
  std::vector<system::Support> supports;
  for (const system::Support& s : c.supports)
    if (s.release > t) supports.push_back(s);
  return supports;
}

/// The acceleration of a checkpoint is that of the supports which held before; where one lets go it is found anew.
bool has_acceleration(const Case& c, const Carried& start) {
  return !start.acceleration.empty() && std::none_of(c.supports.begin(), c.supports.end(),
                                                     [&](const system::Support& s) { return s.release == start.time; });
}

}  // namespace

io::Checkpoint read_start(const RunOptions& options, const system::Model& model) {
  io::Checkpoint c;
  std::vector<double> numbers(4, 0.0);
  if (options.restart.empty()) return c;
  check_restart_folder(model.comm(), options);
  mpi::on_root(model.comm(), [&] {
    c = io::read_checkpoint(options.restart, model.mesh());
    numbers = {static_cast<double>(c.step), c.time, c.next_step, c.acceleration.empty() ? 0.0 : 1.0};
  });
  mpi::broadcast(model.comm(), numbers);
  c.step = static_cast<int>(numbers[0]);
  c.time = numbers[1];
  c.next_step = numbers[2];
  if (numbers[3] > 0.0 && c.acceleration.empty()) c.acceleration.resize(1);  // known to rank 0: marks that there is one
  return c;
}

Summary run_dynamic(const Case& c, const RunOptions& options, system::Model& model, Recorder& recorder,
                    const io::Checkpoint& start, std::string& reason) {
  const SignalScope signals;
  Carried state = start;
  Checkpoints checkpoints(c, options, model.mesh());
  Summary summary;
  summary.converged = true;
  const double first_time = state.time;
  for (const double end : epoch_ends(c, state.time)) {
    std::optional<system::Model> rebuilt;
    const std::vector<system::Support> supports = holding(c, state.time);
    if (supports.size() < c.supports.size())
      rebuilt.emplace(
          model.comm(), model.mesh(),
          system::ModelInput{c.element, c.materials, supports, c.loads, contact_input(PETSC_COMM_WORLD, c)});
    system::Model& now = rebuilt ? *rebuilt : model;
    recorder.use(now);
    if (state.time > first_time)
      recorder.remark(fmt::format("t = {:.6g} s: {} support(s) hold", state.time, supports.size()));
    system::Dynamics dynamics(now, c.dynamics);
    solve::TimeOptions steps = c.time.options;
    steps.end_time = end;
    solve::TimeIntegration time(dynamics, steps);
    State x(state, now);
    bool first = true, stop = false;
    time.on_remark([&](const std::string& text) { recorder.remark(text); });
    time.on_step([&](const solve::TimeReport& r) {
      // A new epoch begins with the state that the last one recorded.
      if (!std::exchange(first, false) || state.time == first_time) recorder.record(r, dynamics);
      const bool ends = r.state.time >= end;
      if (r.taken > 0.0) {
        stop = checkpoints.after_step(r, now);
        if (stop || r.state.time >= c.time.options.end_time) checkpoints.write(r, now);
        summary.residual = r.newton.residual;
        summary.negative_pivots = r.newton.negative_pivots;
        if (ends || stop) state = carry(r, now);
      }
      return stop;
    });
    const bool given = state.time == first_time && has_acceleration(c, state);
    const solve::TimeResult r =
        time.run({state.step, state.time, state.next_step, x.u, x.v, given ? static_cast<Vec>(x.a) : nullptr});
    summary.steps += r.steps;
    summary.newton_iterations += r.newton_iterations;
    summary.factorisations += r.factorisations;
    summary.time = r.state.time;
    summary.load_factor = now.load_factor();
    // The vectors went with the model; numbers are the same on all ranks.
    state.step = r.state.step;
    state.time = r.state.time;
    state.next_step = steps.step;
    recorder.use(model);
    if (stop) reason = fmt::format("stopped by SIGTERM; go on with --restart {}", checkpoints.file().string());
    if (!r.completed) reason = r.reason;
    summary.converged = reason.empty();
    if (!summary.converged || state.time < end) break;  // -ts_max_steps may end it early
  }
  return summary;
}

Summary run_drape(const Case& c, system::Model& model, Recorder& recorder, Vec a, std::string& reason) {
  model.set_load_factor(1.0);
  recorder.record({.step = 0, .load_factor = 0.0, .newton = {}, .critical = {}}, a);
  const solve::DrapeResult r = solve::drape(model, a, c.drape, [&](const std::string& text) { recorder.remark(text); });
  recorder.record({.step = 1, .load_factor = 1.0, .newton = r.newton, .last = true, .critical = {}}, a);
  recorder.remark(fmt::format("residual {:.3e} N ({:.1e} of the forces); {}; eigenvalue nearest to zero {:.4g} 1/s^2",
                              r.residual, r.newton.residual,
                              r.stable                       ? "stable"
                              : r.newton.negative_pivots < 0 ? "stability not known (follower loads)"
                                                             : "UNSTABLE",
                              r.eigenvalue));
  Summary s;
  s.converged = r.newton.converged;
  s.load_factor = 1.0;
  s.steps = 1;
  s.newton_iterations = r.newton.iterations;
  s.factorisations = r.newton.factorisations;
  s.negative_pivots = r.newton.negative_pivots;
  s.residual = r.newton.residual;
  if (!s.converged) reason = r.newton.reason;
  if (s.converged && r.newton.negative_pivots > 0) {
    s.converged = false;
    reason = fmt::format("the equilibrium is unstable ({} negative pivots) after {} escapes", r.newton.negative_pivots,
                         r.escapes);
  }
  return s;
}

}  // namespace voile::app

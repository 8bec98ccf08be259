#include "run_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>
#include <utility>

#include "voile/base/error.hpp"
#include "voile/base/interrupt.hpp"
#include "voile/base/mpi.hpp"
#include "voile/io/checkpoint.hpp"
#include "voile/solve/time_integration.hpp"

namespace voile::app {

namespace {

using Clock = std::chrono::steady_clock;

/// A state between models: global axes, mesh order, on rank 0.
using Carried = io::Checkpoint;

Carried carry(const solve::TimeState& s, const system::Model& model) {
  Carried c{s.step, s.time, s.next_step, model.dofs().gather(s.position), model.dofs().gather(s.velocity), {}};
  if (s.acceleration) c.acceleration = model.dofs().gather(s.acceleration);
  if (model.contact()) {
    const system::ContactMemory& memory = model.contact()->memory();
    c.contact_gaps = memory.gaps;
    c.contact_start = memory.start;
    c.yielding = memory.yielding;
  }
  return c;
}

/// Unknowns of one model.
struct State {
  petsc::VecHandle u, v, a;

  State(const Carried& from, const system::Model& model)
      : u(model.dofs().create_vector()), v(model.dofs().create_vector()), a(model.dofs().create_vector()) {
    scatter(from.displacement, u, model);
    scatter(from.velocity, v, model);
    scatter(from.acceleration, a, model);
  }
  static void scatter(std::vector<double> values, Vec to, const system::Model& model) {
    values.resize(static_cast<std::size_t>(model.dofs().unknowns()), 0.0);  // nothing given: zero
    model.dofs().scatter(values, to);
  }
};

/// Writes checkpoints when they are due or asked for.
class Checkpoints {
 public:
  Checkpoints(const input::Case& c, const RunOptions& options, const mesh::SurfaceMesh& mesh)
      : section_(c.time), file_(options.output / "checkpoint.h5"), mesh_(mesh) {}

  /// Collective.
  void after_step(const solve::TimeState& s, const system::Model& model) {
    const double minutes = std::chrono::duration<double>(Clock::now() - last_).count() / 60.0;
    const bool by_time = section_.checkpoint_minutes > 0.0 && minutes >= section_.checkpoint_minutes;
    const bool by_step = section_.checkpoint_steps > 0 && s.step % section_.checkpoint_steps == 0;
    const bool due = mpi::max(model.comm(), by_time ? 1.0 : 0.0) > 0.0;  // clocks differ between ranks
    const bool asked = SignalScope::take_checkpoint(model.comm());
    if (due || by_step || asked) write(s, model);
  }
  /// Collective.
  void write(const solve::TimeState& s, const system::Model& model) {
    const Carried c = carry(s, model);
    mpi::on_root(model.comm(), [&] { io::write_checkpoint(file_, c, mesh_); });
    last_ = Clock::now();
  }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  const input::TimeSection& section_;
  std::filesystem::path file_;
  const mesh::SurfaceMesh& mesh_;
  Clock::time_point last_ = Clock::now();
};

/// Times within the run at which a support lets go, and its end.
std::vector<double> epoch_ends(const input::Case& c, double start) {
  std::set<double> ends{c.time.options.end_time};
  for (const system::Support& s : c.supports)
    if (s.release > start && s.release < c.time.options.end_time) ends.insert(s.release);
  return {ends.begin(), ends.end()};
}

/// Supports that still hold after time t.
std::vector<system::Support> holding(const input::Case& c, double t) {
  std::vector<system::Support> supports;
  for (const system::Support& s : c.supports)
    if (s.release > t) supports.push_back(s);
  return supports;
}

/// The acceleration of a checkpoint is that of the supports which held before; where one lets go it is found anew.
bool has_acceleration(const input::Case& c, const Carried& start) {
  return !start.acceleration.empty() && std::none_of(c.supports.begin(), c.supports.end(),
                                                     [&](const system::Support& s) { return s.release == start.time; });
}

/// One model's part of a motion: from `state`, to where its supports change.
class Epoch {
 public:
  Epoch(const input::Case& c, system::Model& model, const Carried& state, double end)
      : dynamics_(model, c.dynamics), time_(dynamics_, until(c, end)), x_(state, model), start_(state) {}

  /// Contact lets out what starts within its distance; `is_new`: nothing has run before.
  void settle_contact(bool is_new) {
    system::Contact* contact = dynamics_.model().contact();
    if (!contact) return;
    if (!is_new) return contact->restore({start_.contact_gaps, start_.contact_start, start_.yielding});
    dynamics_.set_time(start_.time);
    system::settle_contact(dynamics_.model(), x_.u, start_.time);
  }

  solve::TimeResult run(Recorder& recorder, Checkpoints& checkpoints, bool is_first, bool has_acceleration) {
    bool first = true;
    time_.on_remark([&](const std::string& text) { recorder.remark(text); });
    time_.on_step([&](const solve::TimeReport& r) {
      // A new epoch begins with the state that the last one recorded.
      if (!std::exchange(first, false) || is_first) recorder.record(r, dynamics_);
      if (r.taken > 0.0) checkpoints.after_step(r.state, dynamics_.model());
      return SignalScope::stop_asked(dynamics_.model().comm());
    });
    return time_.run(
        {start_.step, start_.time, start_.next_step, x_.u, x_.v, has_acceleration ? static_cast<Vec>(x_.a) : nullptr});
  }

 private:
  static solve::TimeOptions until(const input::Case& c, double end) {
    solve::TimeOptions options = c.time.options;
    options.end_time = end;
    return options;
  }
  system::Dynamics dynamics_;
  solve::TimeIntegration time_;
  State x_;
  const Carried& start_;
};

void add(Summary& summary, const solve::TimeResult& r, const system::Model& model) {
  summary.steps += r.steps;
  summary.newton_iterations += r.newton_iterations;
  summary.factorisations += r.factorisations;
  summary.time = r.state.time;
  summary.load_factor = model.load_factor();
  summary.residual = r.newton.residual;
  summary.negative_pivots = r.newton.negative_pivots;
}

}  // namespace

Summary run_dynamic(const input::Case& c, const RunOptions& options, const system::ModelInput& input,
                    system::Model& model, Recorder& recorder, const io::Checkpoint& start, std::string& reason) {
  Carried state = start;
  Checkpoints checkpoints(c, options, model.mesh());
  Summary summary;
  const double first_time = state.time;
  for (const double end : epoch_ends(c, state.time)) {
    std::optional<system::Model> rebuilt;
    system::ModelInput held = input;
    held.supports = holding(c, state.time);
    const std::size_t count = held.supports.size();
    if (count < c.supports.size()) rebuilt.emplace(model.comm(), model.mesh(), std::move(held));
    system::Model& now = rebuilt ? *rebuilt : model;
    recorder.use(now);
    const bool is_first = state.time == first_time;
    if (!is_first) recorder.remark(fmt::format("t = {:.6g} s: {} support(s) hold", state.time, count));
    Epoch epoch(c, now, state, end);
    epoch.settle_contact(is_first && options.restart.empty());
    const solve::TimeResult r = epoch.run(recorder, checkpoints, is_first, is_first && has_acceleration(c, state));
    add(summary, r, now);
    reason = r.stopped ? "" : r.reason;
    const bool at_release = r.completed && !r.stopped && r.state.time >= end && end < c.time.options.end_time;
    if (at_release) {
      state = carry(r.state, now);
    } else {  // the end, a failure, a signal or -ts_max_steps: it can be gone on from here
      checkpoints.write(r.state, now);
    }
    recorder.finish();
    recorder.use(model);
    if (r.stopped && r.state.time < c.time.options.end_time)
      reason = fmt::format("stopped by a signal; go on with --restart {}", checkpoints.file().string());
    if (!at_release) break;
  }
  summary.converged = reason.empty();
  return summary;
}

Summary run_drape(const input::Case& c, system::Model& model, Recorder& recorder, Vec a, std::string& reason) {
  model.set_load_factor(1.0);
  recorder.record({.step = 0, .load_factor = 0.0, .newton = {}, .critical = {}}, a);
  const auto record = [&](const solve::NewtonResult& n) {
    recorder.record({.step = 1, .load_factor = 1.0, .newton = n, .last = true, .critical = {}}, a);
  };
  solve::DrapeResult r;
  try {
    r = solve::drape(model, a, c.drape, [&](const std::string& text) { recorder.remark(text); });
  } catch (const Interrupted&) {
    record({});  // not in equilibrium, but --restart goes on from there
    throw;
  }
  record(r.newton);
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

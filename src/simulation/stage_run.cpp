// The method on one page: advance, record, checkpoint; where supports release or the mesh no longer suits the folds, open the
// next epoch from the same state.
#include "stage_run.hpp"

#include <fmt/format.h>

#include <utility>

#include "base/interrupt.hpp"
#include "base/mpi.hpp"
#include "modes.hpp"
#include "record/discretisation_error.hpp"
#include "record/garment_measures.hpp"
#include "record/report.hpp"
#include "setup/mesh_report.hpp"
#include "sewing.hpp"
#include "solve/load_path.hpp"
#include "solve/single_step.hpp"
#include "system/contact.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

namespace {

using solve::Outcome;
using solve::StepResult;

record::Summary summary_of(const solve::RunStatistics& all, const system::State& state, const input::Case& c,
                           const system::Model& model) {
  record::Summary s;
  s.converged = all.completed;
  s.element = energy::element_types[energy::type_of(c.element)].name;
  s.angle_triangles = setup::angle_triangles(model.discretisation().sheet());
  s.reason = all.reason;
  s.load_factor = state.load_factor;
  s.steps = c.analysis == input::Analysis::statics ? state.step : all.steps;
  s.newton_iterations = all.newton_iterations;
  s.factorisations = all.factorisations;
  s.iterative = all.iterative;
  s.critical = all.critical;
  s.time = state.time;
  if (c.analysis == input::Analysis::dynamic) s.balance = state.balance;
  s.negative_pivots = all.newton.negative_pivots;
  s.eigenvalue = all.eigenvalue;
  s.keeps_state = c.finds_modes();
  s.residual = all.newton.residual;
  s.unknowns = model.dofs().unknowns();
  s.vertices = model.dofs().mesh().vertex_count();
  s.triangles = model.dofs().mesh().triangle_count();
  s.ranks = mpi::size(model.dofs().comm());
  return s;
}

}  // namespace

StageRun::StageRun(const Stage& stage, Start start)
    : stage_(stage),
      mesh_(std::move(start.mesh)),
      epoch_(std::move(start.epoch)),
      origin_(start.origin),
      cpu_before_(origin_ != Origin::restart && stage.c.stage.number > 0 ? record::cpu_seconds(comm()) : 0.0),
      recorder_(stage.c, stage.options, epoch_->model()),
      checkpoints_(stage.c, stage.options.output) {
  if (stage.c.remesh.active) remesher_.emplace(stage, std::move(start.first));
  put_forces(std::move(start.forces));
}

void StageRun::begin() {
  try {
    open(origin_);
  } catch (const Interrupted& e) {  // in the search for a start
    all_.completed = false;
    all_.interrupted = done_ = true;
    all_.reason = e.what();
  }
}

/// The epoch begins: supports and obstacles go where they are.
void StageRun::open(Origin origin) {
  origin_ = origin;
  limit_.reset();
  system::Model& model = epoch_->model();
  recorder_.use(model, nullptr);
  apply_forces();
  stepper_ = &epoch_->make_stepper(recorder_, origin);
  stepper_->on_remark([this](const std::string& text) { recorder_.remark(text); });
  stepper_->on_progress([this](const std::string& text) { recorder_.progress(text); });
  recorder_.use(model, epoch_->dynamics());
  if (remesher_) recorder_.use_sizes([this] { return remesher_->wanted_sizes(*epoch_); });
  take(stepper_->begin(epoch_->state()));
}

StepResult StageRun::advance(double until) {
  StepResult r;
  try {
    limit(until);
    do {
      r = stepper_->advance(epoch_->state());
      take(r);
    } while (r.outcome == Outcome::not_yet && !done_);
  } catch (const Interrupted& e) {  // between two steps, or in the search for a start
    all_.completed = false;
    all_.interrupted = done_ = true;
    all_.reason = e.what();
    r.interrupted = true;
    if (r.taken == 0.0) r.outcome = Outcome::failed;
  }
  r.mode = nullptr;  // its owner may be gone
  return r;
}

/// What is accepted is recorded, what fails is tried again by the stepper with less.
void StageRun::take(const StepResult& r) {
  system::State& state = epoch_->state();
  const bool accepted = r.outcome == Outcome::accepted, finished = accepted && is_at_end(), is_start = r.taken == 0.0;
  const MPI_Comm comm = this->comm();
  all_.add(r);
  // A new epoch begins with the state that the last one recorded, unless that is an equilibrium of another mesh.
  const bool is_known = is_start && (origin_ == Origin::epoch || origin_ == Origin::saved ||
                                     (origin_ == Origin::mesh && epoch_->moves()));
  if ((accepted && !is_known) || r.worth_keeping) {
    const bool asked = SignalScope::take_checkpoint(comm);
    recorder_.record(state, r, finished || r.worth_keeping || asked);
    if (!is_start) checkpoints_.after_step(state, epoch_->model(), asked);
  }
  // A checkpoint is of the state that was to be looked at: a run that continues from it looks first, as the unbroken
  // one did.
  if (accepted && !finished) stop_if_asked(comm);
  // A path that stops at a critical point, or leaves it along the mode of this mesh, keeps the mesh there.
  const bool looks = !r.mode && (!is_start || origin_ == Origin::nothing || origin_ == Origin::restart);
  if (accepted && remesher_ && looks && remesher_->due(*epoch_, finished)) {
    recorder_.write_pending();
    if (std::optional<remesh::RemeshResult> next =
            remesher_->adapt(*epoch_, [&](const auto& text) { recorder_.remark(text); })) {
      epoch_ = std::move(next->epoch);
      mesh_ = std::move(next->mesh);
      put_forces({});
      return open(Origin::mesh);
    }
  }
  all_.completed = finished;
  if (finished || r.outcome == Outcome::failed) end_epoch();
}

/// The end of the stage, or other supports.
void StageRun::end_epoch() {
  const system::State& state = epoch_->state();
  done_ = !all_.completed || !epoch_->ends_at(state.time);
  if (done_) return;
  const results::Checkpoint start = remesh::gather(state, epoch_->model());
  recorder_.write_pending();
  epoch_ = std::make_unique<Epoch>(comm(), stage_.c, epoch_->model().dofs().mesh(), stage_.input, stage_.frozen, start);
  recorder_.remark(fmt::format("t = {:.6g} s: released; {}", start.time, epoch_->holders()));
  open(Origin::epoch);
}

/// Whether the stepper has ended for good, not only where it waits on request.
bool StageRun::is_at_end() const {
  const system::State& state = epoch_->state();
  return stepper_->finished(state) && !(limit_ && state.time >= *limit_);
}

void StageRun::limit(double until) {
  solve::TimeIntegration* motion = epoch_->motion();
  const std::optional<double> wanted = until < epoch_->end() ? std::optional(until) : std::nullopt;
  if (!motion || wanted == limit_) return;
  motion->end_at(epoch_->state(), wanted.value_or(epoch_->end()));
  limit_ = wanted;
}

void StageRun::set_forces(std::vector<double> forces) {
  if (mpi::max(comm(), forces.empty() ? 0.0 : 1.0) > 0.0) require_kept_forces(stage_.c);
  put_forces(std::move(forces));
}

void require_kept_forces(const input::Case& c) {
  if (!c.remesh.active || c.analysis == input::Analysis::dynamic) return;
  throw UserError(
      "set_forces: [remesh] would leave the new mesh without them before an equilibrium is found; give them as "
      "[[load]], take them away, or take [remesh] out");
}

void StageRun::put_forces(std::vector<double> forces) {
  forces_ = std::move(forces);
  has_forces_ = mpi::max(comm(), forces_.empty() ? 0.0 : 1.0) > 0.0;
  apply_forces();
}

/// Modes are those about the equilibrium with the forces from outside, which may have come after the start.
void StageRun::balance_forces() {
  const input::Case& c = stage_.c;
  system::State& state = epoch_->state();
  if (!has_forces_ || !all_.completed || !c.finds_modes() || solve::is_balanced(epoch_->model(), state.u)) return;
  state.in_equilibrium = false;
  const StepResult r = solve::Equilibrium(epoch_->model(), true).begin(state);
  all_.completed = r.outcome != Outcome::failed;
  if (!all_.completed) all_.reason = r.reason;
}

void StageRun::apply_forces() {
  system::Model& model = epoch_->model();
  petsc::VecHandle force;
  if (has_forces_) force = model.dofs().create_vector();
  if (has_forces_) model.dofs().scatter_forces(forces_, force);
  model.conditions().set_external(std::move(force));
}

StageRun::Saved StageRun::save() const {
  // What a signal has stopped goes on from here.
  solve::RunStatistics all = all_;
  const bool stopped = std::exchange(all.interrupted, false);
  return {mesh_,
          remesh::gather_whole(epoch_->state(), epoch_->model()),
          all,
          recorder_.history().rows.size(),
          done_ && !stopped,
          forces_};
}

void StageRun::restore(const Saved& saved) {
  recorder_.forget_rows(saved.rows);
  done_ = false;
  auto epoch = std::make_unique<Epoch>(comm(), stage_.c, *saved.mesh, stage_.input, stage_.frozen, saved.state);
  epoch_ = std::move(epoch);
  mesh_ = saved.mesh;
  put_forces(saved.forces);
  open(Origin::saved);
  all_ = saved.all;
  done_ = saved.done;
}

// Path following goes along unstable branches on purpose.
bool StageRun::ends_unstable() const {
  const input::Case& c = stage_.c;
  return c.analysis == input::Analysis::statics && c.steps.control == solve::StaticOptions::Control::load &&
         all_.completed && all_.newton.negative_pivots > 0;
}

record::Summary StageRun::end() {
  const input::Case& c = stage_.c;
  system::Model& model = epoch_->model();
  const system::State& state = epoch_->state();
  balance_forces();
  checkpoints_.write(state, model, all_.completed);
  if (all_.completed && !c.stage.sew.empty()) {
    all_.reason = open_seam_text(c, model, state);
    all_.completed = all_.reason.empty();
  }
  record::Summary summary = summary_of(all_, state, c, model);
  summary.unstable = ends_unstable();
  if (all_.interrupted && c.analysis == input::Analysis::dynamic)
    summary.reason = checkpoints_.file().empty()
                         ? all_.reason
                         : fmt::format("stopped by a signal; continue with --restart {}", checkpoints_.file().string());
  if (summary.converged && c.finds_modes()) run_modes(c, stage_.options, model, state.u, summary);
  if (remesher_) summary.remeshing = remesher_->effort();
  if (remesher_ && !remesh::text_of(*summary.remeshing).empty()) recorder_.remark(remesh::text_of(*summary.remeshing));
  recorder_.finish();
  if (!c.stage.sew.empty()) recorder_.report_seams(state);
  summary.membrane_error = recorder_.membrane_error();
  summary.failure = recorder_.failure();
  summary.recovery_error = recorder_.recovery_error().last();
  summary.largest_recovery_error = recorder_.recovery_error().largest();
  if (c.analysis == input::Analysis::dynamic) {
    summary.kinetic = recorder_.kinetic();
    summary.round_off_energy = record::round_off_energy(model.discretisation().sheet());
  }
  if (system::Contact* contact = model.contact()) summary.contact = system::report(contact->scene(), state.u);
  if (!c.panels.empty() && c.analysis != input::Analysis::linear)
    summary.garment = record::measure_garment(c, model, state);
  summary.wall_seconds = recorder_.wall_seconds();
  summary.cpu_seconds = record::cpu_seconds(comm()) - cpu_before_;
  record::report_end(c, stage_.options, summary);
  return summary;
}

}  // namespace voile::simulation

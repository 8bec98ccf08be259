// The method on one page: read, build, and while the end is not reached: advance, record, checkpoint; where supports
// let go, the mesh no longer suits the folds, or a stage ends, open the next epoch from the same state.
#include "voile/app/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "carry.hpp"
#include "contact_start.hpp"
#include "epoch.hpp"
#include "garment.hpp"
#include "group_names.hpp"
#include "model_input.hpp"
#include "modes.hpp"
#include "output_folder.hpp"
#include "probes.hpp"
#include "recorder.hpp"
#include "remesher.hpp"
#include "report.hpp"
#include "restart.hpp"
#include "sewing.hpp"
#include "stages.hpp"
#include "start_supports.hpp"
#include "voile/base/interrupt.hpp"
#include "voile/base/mpi.hpp"
#include "voile/system/contact.hpp"
#include "weld_settle.hpp"

namespace voile::app {

namespace {

using solve::Outcome;
using solve::StepResult;

/// --verbose shows every Newton iteration, exactly as -snes_monitor does.
void show_iterations() {
  PetscBool given = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-snes_monitor", &given));
  if (!given) VOILE_PETSC(PetscOptionsSetValue(nullptr, "-snes_monitor", nullptr));
}

using Mesh = std::shared_ptr<const mesh::SurfaceMesh>;

/// What one stage needs all along.
struct Following {
  Recorder& recorder;
  Checkpoints& checkpoints;
  std::optional<Remesher>& remesher;
  solve::Followed& all;
};

/// Advances an epoch to its end: supports and obstacles go where they are at each step, what is accepted is recorded,
/// what fails is tried again by the stepper with less. Returns what the run goes on with if that is another mesh.
std::optional<Adapted> advance(Epoch& epoch, Origin origin, const Following& f) {
  Recorder& recorder = f.recorder;
  std::optional<Remesher>& remesher = f.remesher;
  const system::Dofs& dofs = epoch.model().dofs();
  recorder.use(epoch.model(), nullptr);
  solve::Stepper& stepper = epoch.make_stepper(recorder, origin);
  stepper.on_remark([&](const std::string& text) { recorder.remark(text); });
  recorder.use(epoch.model(), epoch.dynamics());
  if (remesher) recorder.use_sizes([&] { return remesher->wanted_sizes(epoch); });
  for (StepResult r = stepper.begin(epoch.state());; r = stepper.advance(epoch.state())) {
    const bool accepted = r.outcome == Outcome::accepted, finished = accepted && stepper.finished(epoch.state());
    const bool is_start = r.taken == 0.0;
    f.all.add(r);
    // A new epoch begins with the state that the last one recorded, unless that is an equilibrium of another mesh.
    const bool is_known = is_start && (origin == Origin::epoch || (origin == Origin::mesh && epoch.moves()));
    if ((accepted && !is_known) || r.worth_keeping) {
      const bool asked = SignalScope::take_checkpoint(dofs.comm());
      recorder.record(epoch.state(), r, finished || r.worth_keeping || asked);
      if (!is_start) f.checkpoints.after_step(epoch.state(), epoch.model(), asked);
    }
    // A checkpoint is of the state that was to be looked at: a run that goes on from it looks first, as the unbroken
    // one did.
    if (accepted && !finished) stop_if_asked(dofs.comm());
    // A path that stops at a critical point, or leaves it along the mode of this mesh, keeps the mesh there.
    const bool looks = !r.mode && (!is_start || origin == Origin::nothing || origin == Origin::restart);
    if (accepted && remesher && looks && remesher->due(epoch, finished)) {
      recorder.write_pending();
      if (std::optional<Adapted> next = remesher->adapt(epoch, [&](const auto& text) { recorder.remark(text); }))
        return next;
    }
    f.all.completed = finished;
    if (finished || r.outcome == Outcome::failed) return std::nullopt;
  }
}

Summary summary_of(const solve::Followed& all, const system::State& state, const input::Case& c,
                   const system::Model& model) {
  Summary s;
  s.converged = all.completed;
  s.element = energy::element_types[energy::type_of(c.element)].name;
  s.reason = all.reason;
  s.load_factor = state.load_factor;
  s.steps = c.analysis == "static" ? state.step : all.steps;
  s.newton_iterations = all.newton_iterations;
  s.factorisations = all.factorisations;
  s.iterative = all.iterative;
  s.critical = all.critical;
  s.time = state.time;
  if (c.analysis == "dynamic") s.balance = state.balance;
  s.negative_pivots = all.newton.negative_pivots;
  // Path following goes along unstable branches on purpose.
  s.unstable = c.analysis == "static" && c.steps.control == solve::StaticOptions::Control::load && s.converged &&
               s.negative_pivots > 0;
  s.residual = all.newton.residual;
  s.unknowns = model.dofs().unknowns();
  s.vertices = model.dofs().mesh().vertex_count();
  s.triangles = model.dofs().mesh().triangle_count();
  return s;
}

/// Runs one stage from `state` to its end, and leaves its last state and mesh there. `first`: the mesh of the case.
/// Collective.
Summary run_stage(const Stage& stage, std::unique_ptr<Epoch> epoch, io::Checkpoint& state, Origin origin,
                  const Mesh& first, Mesh& mesh) {
  const input::Case& c = stage.c;
  const double cpu_before = origin == Origin::stage ? cpu_seconds() : 0.0;
  Recorder recorder(c, stage.options, epoch->model());
  Checkpoints checkpoints(c, stage.options.output);
  solve::Followed all;
  std::optional<Remesher> remesher;
  if (c.remesh.active) remesher.emplace(stage, first);
  try {
    for (;; origin = Origin::epoch) {
      std::optional<Adapted> next = advance(*epoch, origin, {recorder, checkpoints, remesher, all});
      while (next) {
        epoch = std::move(next->epoch);
        mesh = std::move(next->mesh);
        next = advance(*epoch, Origin::mesh, {recorder, checkpoints, remesher, all});
      }
      if (!all.completed || !epoch->ends_at(epoch->state().time)) break;
      state = gather(epoch->state(), epoch->model().dofs());
      recorder.write_pending();
      epoch = std::make_unique<Epoch>(c, epoch->model().dofs().mesh(), stage.input, stage.frozen, state);
      recorder.remark(fmt::format("t = {:.6g} s: {} support(s) hold", state.time, epoch->support_count()));
    }
  } catch (const Interrupted& e) {  // between two steps, or in the search for a start
    all.completed = false;
    all.interrupted = true;
    all.reason = e.what();
  }
  checkpoints.write(epoch->state(), epoch->model());
  if (all.completed && !c.stage.sew.empty()) {
    all.reason = open_seam_text(c, epoch->model(), epoch->state());
    all.completed = all.reason.empty();
  }
  Summary summary = summary_of(all, epoch->state(), c, epoch->model());
  if (all.interrupted && c.analysis == "dynamic")
    summary.reason = fmt::format("stopped by a signal; go on with --restart {}", checkpoints.file().string());
  if (summary.converged && (c.analysis == "modal" || c.analysis == "buckling"))
    run_modes(c, stage.options, epoch->model(), epoch->state().u, summary);
  if (remesher) summary.remeshing = remesher->effort();
  if (remesher && !text_of(*summary.remeshing).empty()) recorder.remark(text_of(*summary.remeshing));
  recorder.finish();
  summary.membrane_error = recorder.membrane_error();
  summary.recovery_error = recorder.recovery_error();
  if (c.analysis == "dynamic") summary.kinetic = recorder.kinetic();
  state = gather(epoch->state(), epoch->model().dofs());
  if (system::Contact* contact = epoch->model().contact())
    summary.contact = system::report(contact->scene(), epoch->state().u);
  if (!c.panels.empty() && c.analysis != "linear") summary.garment = measure_garment(c, epoch->model(), epoch->state());
  summary.wall_seconds = recorder.wall_seconds();
  summary.cpu_seconds = cpu_seconds() - cpu_before;
  report_end(c, stage.options, summary);
  return summary;
}

/// The mesh of the case. Collective. Throws UserError.
mesh::SurfaceMesh load_case_mesh(const input::Case& c) {
  mesh::SurfaceMesh mesh = case_mesh(c);
  const auto remeshes = [](const input::Case& one) { return one.remesh.active || !one.stage.sew.empty(); };
  if (!remeshes(c) && std::none_of(c.stages.begin(), c.stages.end(), remeshes)) return mesh;
  mesh::MeshData data = mesh.data();
  name_probes(c, data);
  return mesh::SurfaceMesh(std::move(data));
}

/// The first epoch of a stage, with a start that contact allows.
std::unique_ptr<Epoch> open_stage(const Stage& stage, const mesh::SurfaceMesh& mesh, const io::Checkpoint& state,
                                  bool is_first) {
  check_remesh(stage.c, mesh);
  auto epoch = std::make_unique<Epoch>(stage.c, mesh, stage.input, stage.frozen, state);
  (void)Probes(stage.c, epoch->model());  // what is wrong with them must show before old results go
  report_model(stage.c, stage.options, epoch->model(), is_first);
  return epoch;
}

void settle_contact_start(const Stage& stage, Epoch& epoch, Origin origin) {
  system::Contact* contact = epoch.model().contact();
  if (!contact) return;
  contact->restore(epoch.state().contact);
  settle_start(stage.c, stage.options, *contact, epoch.state().u, epoch.state().time, origin == Origin::nothing);
}

}  // namespace

Exit run(const input::Case& c, const RunOptions& given) {
  const SignalScope signals;
  const Mesh first = std::make_shared<const mesh::SurfaceMesh>(load_case_mesh(c));
  check_group_names(c, *first);
  if (given.verbosity == Verbosity::verbose) show_iterations();
  RunOptions options = given;
  std::vector<Stage> stages = stages_of(c, options);
  for (Stage& stage : stages) stage.input.seams = system::with_gather_widths(std::move(stage.input.seams), *first);
  Origin origin = begin_from(c, options, stages);
  const std::vector<Mesh> meshes = stage_meshes(stages, first);
  for (std::size_t k = 1; k < stages.size(); ++k) check_stage(stages[k], *meshes[k]);
  // Whatever is wrong with a restart must show before old results in the output folder go.
  Mesh mesh = mesh_of_start(stages.front().c, options, first);
  io::Checkpoint state = read_start(stages.front().c, options, *mesh, origin);
  if (mesh != first) state.remeshings = std::max(state.remeshings, 1);
  std::optional<OutputFolder> folder;
  std::vector<std::pair<std::string, Summary>> summaries;
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const Stage& stage = stages[k];
    const std::vector<std::string> welded = weld_before(stage, origin, mesh, state);
    enter_stage(stage.c, *mesh, origin, state);
    std::unique_ptr<Epoch> epoch = open_stage(stage, *mesh, state, k == 0);
    if (k == 0 && origin == Origin::nothing) check_start_supports(stage.c, epoch->model(), epoch->state().u);
    mpi::on_root(PETSC_COMM_WORLD, [&] {
      if (!folder) folder.emplace(c, options);
      if (stage.c.is_staged()) folder->add(stage.c);
    });
    settle_contact_start(stage, *epoch, origin);
    const std::string unfolded = settle_weld(*epoch, welded, stage.c.dynamics);
    if (!unfolded.empty() && options.verbosity != Verbosity::quiet)
      mpi::on_root(PETSC_COMM_WORLD, [&] { fmt::print("{}\n", unfolded); });
    summaries.emplace_back(stage.c.stage.name, run_stage(stage, std::move(epoch), state, origin, meshes[k], mesh));
    if (!summaries.back().second.converged) break;
    origin = Origin::stage;
  }
  if (!c.stages.empty())
    mpi::on_root(PETSC_COMM_WORLD, [&] { write_stages(options.output, summaries, stages.size()); });
  const bool done = summaries.size() == stages.size() && summaries.back().second.converged;
  if (!done) return Exit::not_converged;
  return summaries.back().second.unstable ? Exit::unstable : Exit::done;
}

}  // namespace voile::app

// Read, build, and one stage after another.
#include "case_run.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/mpi.hpp"
#include "contact_start.hpp"
#include "excitation.hpp"
#include "record/probes.hpp"
#include "record/report.hpp"
#include "remesh/remesher.hpp"
#include "restart.hpp"
#include "setup/garment.hpp"
#include "setup/group_names.hpp"
#include "setup/start_supports.hpp"
#include "sewing.hpp"
#include "stage_check.hpp"
#include "system/contact.hpp"
#include "voile/errors.hpp"
#include "weld_settle.hpp"

namespace voile::simulation {

namespace {

using Mesh = std::shared_ptr<const mesh::SurfaceMesh>;

/// The mesh of the case. Collective. Throws UserError.
Mesh load_case_mesh(MPI_Comm comm, const input::Case& c) {
  mesh::SurfaceMesh mesh = setup::case_mesh(comm, c);
  setup::check_group_names(c, mesh);
  const auto remeshes = [](const input::Case& one) { return one.remesh.active || !one.stage.sew.empty(); };
  if (!remeshes(c) && std::none_of(c.stages.begin(), c.stages.end(), remeshes))
    return std::make_shared<const mesh::SurfaceMesh>(std::move(mesh));
  mesh::MeshData data = mesh.data();
  remesh::name_probes(c, data);
  return std::make_shared<const mesh::SurfaceMesh>(std::move(data));
}

/// The first epoch of a stage, with a start that contact allows.
std::unique_ptr<Epoch> open_epoch(const Stage& stage, const mesh::SurfaceMesh& mesh, const results::Checkpoint& state,
                                  bool is_first) {
  remesh::check_remesh(stage.options.comm, stage.c, mesh);
  auto epoch = std::make_unique<Epoch>(stage.options.comm, stage.c, mesh, stage.input, stage.frozen, state);
  (void)record::Probes(stage.c, epoch->model());  // what is wrong with them must show before old results go
  record::report_model(stage.c, stage.options, epoch->model(), is_first);
  return epoch;
}

void settle_contact_start(const Stage& stage, Epoch& epoch, Origin origin) {
  system::Contact* contact = epoch.model().contact();
  if (!contact) return;
  system::ContactMemory memory = epoch.state().contact;
  if (stage.c.analysis != input::Analysis::dynamic) memory.passing.clear();
  contact->restore(std::move(memory));
  settle_start(stage.c, stage.options, *contact, epoch.state().u, epoch.obstacle_time(), origin == Origin::nothing);
}

}  // namespace

CaseRun::CaseRun(const input::Case& c, const record::RunOptions& options)
    : case_(c), options_(options), mesh_(load_case_mesh(options.comm, c)) {
  Mesh first = mesh_;
  stages_ = stages_of(case_, options_);
  for (Stage& stage : stages_) stage.input.seams = system::with_gather_widths(std::move(stage.input.seams), *first);
  if (options_.obstacles)
    for (Stage& stage : stages_)
      for (contact::Obstacle& o : stage.input.contact.obstacles) options_.obstacles->take(o);
  origin_ = begin_from(case_, options_, stages_);
  meshes_ = stage_meshes(stages_, first);
  require_straight(stages_.front().c, *first);
  for (std::size_t k = 1; k < stages_.size(); ++k) check_stage(stages_[k], *meshes_[k]);
  if (stages_.front().c.stage.takes_modes) {
    use_modes(0);
    first = mesh_;
  }
  // Whatever is wrong with a restart must show before old results in the output folder go.
  mesh_ = mesh_of_start(stages_.front().c, options_, first);
  state_ = read_start(stages_.front().c, options_, *mesh_, origin_);
  if (mesh_ != first) state_.remeshings = std::max(state_.remeshings, 1);
  open_stage(0);
}

void CaseRun::open_stage(std::size_t number) {
  const Stage& stage = stages_[number];
  if (origin_ == Origin::stage) require_factor(stage, state_.load_factor);
  const std::vector<std::string> welded = weld_before(stage, origin_, mesh_, state_);
  enter_stage(options_.comm, stage.c, *mesh_, origin_, state_);
  std::unique_ptr<Epoch> epoch = open_epoch(stage, *mesh_, state_, number == 0);
  if (origin_ == Origin::nothing) setup::check_start_supports(stage.c, epoch->model(), epoch->state().u);
  mpi::on_root(options_.comm, [&] {
    if (options_.output.empty()) return;
    if (!folder_) folder_.emplace(case_, options_);
    if (stage.c.is_staged()) folder_->add(stage.c);
  });
  settle_contact_start(stage, *epoch, origin_);
  const std::string unfolded = settle_weld(*epoch, welded, stage.c.dynamics);
  if (!unfolded.empty() && options_.verbosity != record::Verbosity::quiet)
    mpi::on_root(options_.comm, [&] { fmt::print("{}\n", unfolded); });
  number_ = number;
  stage_ = std::make_unique<StageRun>(
      stage, StageRun::Start{std::move(epoch), mesh_, meshes_[number], origin_, std::move(forces_)});
  stage_->begin();
}

solve::StepResult CaseRun::advance(double until) {
  if (!stage_->done() || go_on()) return stage_->advance(until);
  solve::StepResult none;
  none.outcome = solve::Outcome::not_yet;
  return none;
}

/// From a stage that is done to the next one, which has steps to take if it returns true. A stage stays open, so that its last state
/// can be looked at, and its end left again, until the next one is asked for.
bool CaseRun::go_on() {
  if (stage_->has_forces()) require_kept_forces(stages_[number_ + 1].c);
  end_stage();
  if (!summaries_.back().second.converged) return false;
  origin_ = stages_[number_ + 1].c.stage.continues() ? Origin::stage : Origin::nothing;
  forces_ = stage_->forces();
  stage_.reset();
  if (origin_ == Origin::nothing) begin_anew(number_ + 1);
  open_stage(number_ + 1);
  return !stage_->done();
}

/// The imperfect shape, for a stage and those after it; the mesh in force is the perfect one.
void CaseRun::use_modes(std::size_t number) {
  mesh_ = std::make_shared<const mesh::SurfaceMesh>(
      setup::with_imperfections(options_.comm, stages_[number].c, *mesh_, modes_));
  std::fill(meshes_.begin() + static_cast<std::ptrdiff_t>(number), meshes_.end(), mesh_);
}

/// As the first stage of a run.
void CaseRun::begin_anew(std::size_t number) {
  use_modes(number);
  record::RunOptions options = options_;
  options.restart.clear();
  state_ = read_start(stages_[number].c, options, *mesh_, origin_);
}

void CaseRun::end_stage() {
  const std::string& name = stages_[number_].c.stage.name;
  summaries_.emplace_back(name, stage_->end());
  modes_[name] = std::move(summaries_.back().second.mode_shapes);
  mesh_ = stage_->mesh();
  state_ = remesh::gather_end(stage_->epoch().state(), stage_->epoch().model());
}

StageRun& CaseRun::stage() const {
  if (!stage_) throw UserError("the next stage could not begin, as an error has said; build another simulation");
  return *stage_;
}

bool CaseRun::finished() const {
  if (!stage_) return true;
  if (!stage_->done()) return false;
  return number_ + 1 == stages_.size() || !stage_->all().completed || summaries_.size() > number_;
}

Exit CaseRun::finish() {
  if (summaries_.size() == number_) end_stage();
  if (!case_.stages.empty() && !options_.output.empty()) {
    std::vector<std::string> kept;  // the stages before the one that --from names
    for (const input::Case& one : case_.stages) kept.push_back(one.stage.name);
    kept.resize(kept.size() - stages_.size());
    mpi::on_root(options_.comm, [&] { record::write_stages(options_.output, kept, summaries_, stages_.size()); });
  }
  return outcome();
}

Exit CaseRun::outcome() const {
  const bool has_ended = summaries_.size() > number_;
  const bool done =
      number_ + 1 == stages_.size() && (has_ended ? summaries_.back().second.converged : stage().all().completed);
  if (!done) return Exit::not_converged;
  if (!has_ended && stage().ends_unstable()) return Exit::unstable;
  if (!has_ended && !stage().stage().c.finds_modes()) return Exit::done;
  const auto moves = [](const auto& ended) { return !ended.second.keeps_state || ended.second.unstable; };
  const auto last = std::find_if(summaries_.rbegin(), summaries_.rend(), moves);
  return last != summaries_.rend() && last->second.unstable ? Exit::unstable : Exit::done;
}

CaseRun::Saved CaseRun::save() const {
  return {number_, stage().save(),
          options_.obstacles ? options_.obstacles->tracks() : setup::DrivenObstacles::Tracks{}};
}

void CaseRun::restore(const Saved& saved) {
  if (!options_.output.empty())
    throw UserError(
        "a simulation that writes its results cannot go back to an earlier state: what is written stays; leave the "
        "output "
        "folder out");
  (void)stage();
  if (saved.stage != number_)
    throw UserError(
        fmt::format("the state was saved in stage '{}', and the simulation is in stage '{}'; save states of the "
                    "stage that is in force",
                    stages_[saved.stage].c.stage.name, stages_[number_].c.stage.name));
  if (options_.obstacles) options_.obstacles->restore(saved.obstacles);
  summaries_.resize(number_);
  stage_->restore(saved.state);
}

}  // namespace voile::simulation

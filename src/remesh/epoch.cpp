#include "epoch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "carry.hpp"
#include "energy/natural_state.hpp"
#include "solve/drape.hpp"
#include "solve/path_following.hpp"
#include "solve/single_step.hpp"
#include "system/attachments.hpp"
#include "system/contact.hpp"
#include "system/rigid_places.hpp"

namespace voile::remesh {

namespace {

/// The next time after `start` at which a support releases, or the end of the stage.
double end_of_epoch(const input::Case& stage, double start) {
  double end = stage.time.options.end_time;
  if (stage.analysis != input::Analysis::dynamic) return end;
  for (const system::Support& s : stage.supports)
    if (s.release > start) end = std::min(end, s.release);
  for (const system::Attachment& s : stage.attachments)
    if (s.release > start) end = std::min(end, s.release);
  return end;
}

template <class Holder>
bool holds(const Holder& s, double time) {
  return s.release > time;
}

template <class Holders>
std::size_t holding_count(const Holders& all, double time) {
  return static_cast<std::size_t>(std::count_if(all.begin(), all.end(), [&](const auto& s) { return holds(s, time); }));
}

system::ModelInput holding(system::ModelInput input, const std::vector<char>& frozen, double time) {
  for (std::size_t i = 0; i < input.supports.size(); ++i) {
    if (!frozen[i]) continue;
    system::Support& s = input.supports[i];
    s.motion = nullptr;
    if (s.rotation) s.rotation = [turned = s.rotation(time)](double) { return turned; };
  }
  std::erase_if(input.supports, [&](const system::Support& s) { return !holds(s, time); });
  std::erase_if(input.attachments, [&](const system::Attachment& s) { return !holds(s, time); });
  return input;
}

/// The acceleration of a checkpoint is that of the supports which held before; where one releases it is found anew.
bool lets_go_at(const input::Case& stage, double time) {
  const auto now = [&](const auto& s) { return s.release == time; };
  return std::any_of(stage.supports.begin(), stage.supports.end(), now) ||
         std::any_of(stage.attachments.begin(), stage.attachments.end(), now);
}

/// With rigid groups where the stage has begun. Collective.
system::ModelInput placed(MPI_Comm comm, const input::Case& stage, system::ModelInput input,
                          std::vector<double> places) {
  if (input.rigid.empty()) return input;
  mpi::broadcast(comm, places);
  system::put_rigid_groups(places, stage.analysis == input::Analysis::dynamic, input.rigid);
  return input;
}

bool moves_obstacles(const system::Model& model) {
  if (!model.contact()) return false;
  const std::vector<contact::Obstacle>& all = model.contact()->scene().input().obstacles;
  return std::any_of(all.begin(), all.end(), [](const contact::Obstacle& o) { return static_cast<bool>(o.motion); });
}

bool goes_on(Origin origin) {
  return origin == Origin::epoch || origin == Origin::mesh || origin == Origin::saved;
}

}  // namespace

Epoch::Epoch(MPI_Comm comm, const input::Case& stage, const mesh::SurfaceMesh& mesh, system::ModelInput input,
             const std::vector<char>& frozen, const results::Checkpoint& start)
    : stage_(stage),
      end_(end_of_epoch(stage, start.time)),
      supports_(holding_count(input.supports, start.time)),
      attachments_(holding_count(input.attachments, start.time)),
      model_(comm, mesh, placed(comm, stage, holding(std::move(input), frozen, start.time), start.places)),
      state_(scatter(start, model_.dofs())) {
  if (stage.analysis == input::Analysis::dynamic || stage.vibrates()) system::require_mass(model_);
  if (lets_go_at(stage, start.time)) state_.a.reset();
  model_.couple(start.couplings);
  model_.potential().restore_slips(start.slips);
  std::vector<double> leaks = start.leaks;
  mpi::broadcast(comm, leaks);
  model_.conditions().restore_leaks(leaks);
}

std::string Epoch::holders() const {
  if (attachments_ == 0) return fmt::format("{} support(s) hold", supports_);
  return fmt::format("{} support(s) and {} attachment(s) hold", supports_, attachments_);
}

bool Epoch::ends_at(double time) const {
  return stage_.analysis == input::Analysis::dynamic && time >= end_ && end_ < stage_.time.options.end_time;
}

double Epoch::obstacle_time() const {
  return stage_.moves_obstacles_by_load() ? state_.load_factor : state_.time;
}

void Epoch::prepare(Origin origin) {
  if (std::exchange(prepared_, true)) return;
  const bool in_time = stage_.analysis == input::Analysis::dynamic;
  if (model_.contact())
    model_.contact()->restore(in_time ? state_.contact : system::ContactMemory{{}, 0.0, state_.contact.push, {}});
  if (in_time || stage_.is_staged()) model_.set_time(state_.time);
  if (model_.contact() && stage_.moves_obstacles_by_load()) model_.contact()->set_time(obstacle_time());
  model_.potential().attachments().attach(state_.u, state_.anchors);
  if (stage_.stage.continues()) take_hold(origin);
  if (goes_on(origin)) model_.conditions().set_load_factor(state_.load_factor);
}

solve::Stepper& Epoch::make_stepper(const record::Recorder& recorder, Origin origin) {
  const bool in_time = stage_.analysis == input::Analysis::dynamic;
  prepare(origin);
  in_time ? make_motion(origin) : make_path(recorder, origin);
  return *stepper_;
}

/// Supports of a later stage hold what they find where it is.
void Epoch::take_hold(Origin origin) {
  const double factor = origin == Origin::stage ? 0.0 : state_.load_factor;
  model_.conditions().take_hold(state_.u, stage_.analysis == input::Analysis::statics ? factor : state_.time, factor);
}

void Epoch::make_motion(Origin origin) {
  solve::TimeOptions options = stage_.time.options;
  options.until = end_;
  options.goes_on = goes_on(origin);
  options.restarted = origin == Origin::restart;
  options.released = lets_go_at(stage_, state_.time);
  options.energy_balance = stage_.output.energy_balance;
  dynamics_.emplace(model_, stage_.dynamics);
  auto motion = std::make_unique<solve::TimeIntegration>(*dynamics_, options);
  motion_ = motion.get();
  stepper_ = std::move(motion);
  if (!model_.contact() || goes_on(origin) || origin == Origin::restart) return;
  dynamics_->set_time(state_.time);
  system::settle_contact(model_, state_.u, state_.time);
}

void Epoch::make_path(const record::Recorder& recorder, Origin origin) {
  state_.v.reset();
  state_.a.reset();
  using Control = solve::StaticOptions::Control;
  const solve::StaticOptions& steps = stage_.steps;
  const bool is_given = origin != Origin::nothing;
  if (origin == Origin::restart && state_.in_equilibrium && !model_.contact()) {
    model_.conditions().set_load_factor(state_.load_factor);
    state_.in_equilibrium = solve::is_balanced(model_, state_.u);
  }
  if (stage_.analysis == input::Analysis::linear) {
    stepper_ = std::make_unique<solve::LinearStep>(model_, steps.final_load_factor);
  } else if (stage_.analysis == input::Analysis::drape) {
    stepper_ = std::make_unique<solve::Drape>(model_, stage_.drape);
  } else if (stage_.finds_modes() && stage_.eigen.load_factor == 0.0) {
    const auto is_constant = [](const auto& acting) { return acting.constant; };
    const auto has_history = [&](const system::Load& load) { return stage_.is_staged() && load.history; };
    const bool constant = std::any_of(stage_.loads.begin(), stage_.loads.end(), is_constant) ||
                          std::any_of(stage_.loads.begin(), stage_.loads.end(), has_history) ||
                          std::any_of(stage_.temperatures.begin(), stage_.temperatures.end(), is_constant) ||
                          std::any_of(stage_.hinges.begin(), stage_.hinges.end(), is_constant) ||
                          std::any_of(stage_.materials.begin(), stage_.materials.end(), energy::has_initial_state);
    stepper_ = std::make_unique<solve::Equilibrium>(model_, constant && !is_given);
  } else if (steps.control == Control::load) {
    stepper_ = std::make_unique<solve::LoadPath>(
        model_, steps, stage_.moves_obstacles_by_load() && moves_obstacles(model_), origin == Origin::restart);
  } else {
    const petsc::VecHandle probe =
        steps.control_probe.empty() ? petsc::VecHandle{} : recorder.functional(steps.control_probe);
    stepper_ = std::make_unique<solve::PathFollower>(model_, steps, probe);
  }
}

}  // namespace voile::remesh

// An epoch of a run: one model, constant from the state it begins with to where supports release or the stage ends.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "input/case.hpp"
#include "record/recorder.hpp"
#include "results/checkpoint.hpp"
#include "solve/stepper.hpp"
#include "solve/time_integration.hpp"
#include "system/dynamics.hpp"
#include "system/state.hpp"

namespace voile::remesh {

/// What an epoch continues from: `epoch` the same mesh with other supports, `mesh` another mesh, `saved` an earlier state of this
/// run.
enum class Origin { nothing, restart, stage, epoch, mesh, saved };

class Epoch {
 public:
  /// `input` holds all that the stage names; supports which have released before the start are left out, of those that
  /// are `frozen` only what they hold counts. Mesh and case must outlive it. Collective. Throws UserError.
  Epoch(MPI_Comm comm, const input::Case& stage, const mesh::SurfaceMesh& mesh, system::ModelInput input,
        const std::vector<char>& frozen, const results::Checkpoint& start);

  [[nodiscard]] system::Model& model() { return model_; }
  [[nodiscard]] const system::Model& model() const { return model_; }
  [[nodiscard]] system::State& state() { return state_; }
  [[nodiscard]] const system::State& state() const { return state_; }
  /// Mass and damping of the motion; null outside one.
  [[nodiscard]] const system::Dynamics* dynamics() const { return dynamics_ ? &*dynamics_ : nullptr; }
  /// Puts conditions and contact where the state is. Called by make_stepper(), once. Collective.
  void prepare(Origin origin);
  /// The stepper that the stage's analysis asks for. Collective.
  solve::Stepper& make_stepper(const record::Recorder& recorder, Origin origin);
  /// The stepper, if it is one in time; null otherwise and before make_stepper().
  [[nodiscard]] solve::TimeIntegration* motion() { return motion_; }
  /// Time at which it ends: supports release, or the stage does [s].
  [[nodiscard]] double end() const { return end_; }
  /// Whether another epoch of the stage begins at this time.
  [[nodiscard]] bool ends_at(double time) const;
  /// The time at which obstacles are where this state has them: the load factor, where that moves them.
  [[nodiscard]] double obstacle_time() const;
  /// How many supports and attachments hold, for a message.
  [[nodiscard]] std::string holders() const;
  [[nodiscard]] bool moves() const { return stage_.analysis == input::Analysis::dynamic; }

 private:
  void take_hold(Origin origin);
  void make_motion(Origin origin);
  void make_path(const record::Recorder& recorder, Origin origin);

  const input::Case& stage_;
  double end_;                          ///< time at which supports release, or the stage ends [s]
  std::size_t supports_, attachments_;  ///< that hold
  system::Model model_;
  system::State state_;
  bool prepared_ = false;
  std::optional<system::Dynamics> dynamics_;
  std::unique_ptr<solve::Stepper> stepper_;
  solve::TimeIntegration* motion_ = nullptr;  ///< the same
};

}  // namespace voile::remesh

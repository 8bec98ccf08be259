// One stage of a run, advanced by one accepted step at a time.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "record/recorder.hpp"
#include "record/summary.hpp"
#include "remesh/carry.hpp"
#include "remesh/epoch.hpp"
#include "remesh/remesher.hpp"
#include "stages.hpp"

namespace voile::simulation {

/// Throws UserError for a stage in which a new mesh would lose forces from outside unseen.
void require_kept_forces(const input::Case& c);

class StageRun {
 public:
  using Mesh = std::shared_ptr<const mesh::SurfaceMesh>;
  /// Where a stage begins: an open epoch on `mesh`, what it comes from, and the mesh of the case as the stage finds it.
  struct Start {
    std::unique_ptr<Epoch> epoch;
    Mesh mesh, first;
    Origin origin = Origin::nothing;
    std::vector<double> forces{};  ///< from outside, on rank 0
  };
  /// A state to go back to; arrays on rank 0.
  struct Saved {
    Mesh mesh;
    results::Checkpoint state;
    solve::RunStatistics all;
    std::size_t rows = 0;
    bool done = false;
    std::vector<double> forces;
  };

  /// `stage` must outlive it. Collective. Throws UserError if the files of the results cannot be written.
  StageRun(const Stage& stage, Start start);
  /// Prepares and records the start. Once, before the first step. Collective.
  void begin();
  /// One accepted step, with the new meshes and the changes of supports that follow from it; in a motion not beyond `until`
  /// [s]. On failure the stage is done, and the state is the last accepted one. Collective.
  solve::StepResult advance(double until = std::numeric_limits<double>::infinity());
  /// Whether the end is reached, or nothing more can be done.
  [[nodiscard]] bool done() const { return done_; }
  /// Whether load control has ended in an unstable equilibrium.
  [[nodiscard]] bool ends_unstable() const;
  /// Ends the stage: checkpoint, modes, the last words, summary.json. Once. Collective.
  [[nodiscard]] record::Summary end();

  /// Collective. Arrays on rank 0.
  [[nodiscard]] Saved save() const;
  /// Goes back to a state of this stage. Without an output folder only: what is written stays. Collective.
  void restore(const Saved& saved);
  /// Forces on the vertices besides the loads of the case, three components each, on rank 0; until the mesh is exchanged.
  /// Collective. Throws UserError where a path is remeshed: the new mesh would be without them. [N]
  void set_forces(std::vector<double> forces);
  [[nodiscard]] const std::vector<double>& forces() const { return forces_; }
  [[nodiscard]] bool has_forces() const { return has_forces_; }

  [[nodiscard]] Epoch& epoch() { return *epoch_; }
  [[nodiscard]] const Epoch& epoch() const { return *epoch_; }
  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] record::Recorder& recorder() { return recorder_; }
  [[nodiscard]] const solve::RunStatistics& all() const { return all_; }
  [[nodiscard]] const Stage& stage() const { return stage_; }

 private:
  void open(Origin origin);
  void take(const solve::StepResult& r);
  void end_epoch();
  void limit(double until);
  void apply_forces();
  void balance_forces();
  void put_forces(std::vector<double> forces);
  [[nodiscard]] bool is_at_end() const;
  [[nodiscard]] MPI_Comm comm() const { return stage_.options.comm; }

  const Stage& stage_;
  Mesh mesh_;  ///< of the epoch
  std::unique_ptr<Epoch> epoch_;
  Origin origin_;
  double cpu_before_;
  record::Recorder recorder_;
  remesh::Checkpoints checkpoints_;
  std::optional<remesh::Remesher> remesher_;
  solve::Stepper* stepper_ = nullptr;
  solve::RunStatistics all_;
  bool done_ = false;
  std::optional<double> limit_;  ///< time at which the steps end for now, before the end of the epoch [s]
  std::vector<double> forces_;   ///< rank 0
  bool has_forces_ = false;
};

}  // namespace voile::simulation

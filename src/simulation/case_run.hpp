// A run of a case: its mesh, its stages one after another, and the folder of its results.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "input/case.hpp"
#include "record/output_folder.hpp"
#include "record/run_options.hpp"
#include "record/summary.hpp"
#include "setup/driven_obstacles.hpp"
#include "setup/imperfections.hpp"
#include "stage_run.hpp"
#include "stages.hpp"
#include "voile/errors.hpp"

namespace voile::simulation {

class CaseRun {
 public:
  /// A state to go back to.
  struct Saved {
    std::size_t stage = 0;
    StageRun::Saved state;
    setup::DrivenObstacles::Tracks obstacles;
  };

  /// Reads, builds and begins the first stage. Collective over the communicator of the options. Throws UserError.
  CaseRun(const input::Case& c, const record::RunOptions& options);
  CaseRun(const CaseRun&) = delete;
  CaseRun& operator=(const CaseRun&) = delete;

  /// One accepted step, after the end of the stage before if that is done; in a motion not beyond `until` [s]. No step where the
  /// next stage has none, as modes, or the stage before has failed at its end. Not after finished(). Collective.
  solve::StepResult advance(double until = std::numeric_limits<double>::infinity());
  /// Whether the last stage is done, or one has failed.
  [[nodiscard]] bool finished() const;
  /// Ends the run: what it came to is written and said. Once, after finished(). Collective.
  [[nodiscard]] Exit finish();
  /// With what the program would end now. Throws UserError after the next stage has failed to begin.
  [[nodiscard]] Exit outcome() const;

  /// Collective.
  [[nodiscard]] Saved save() const;
  /// Goes back to a state of this run and of the stage that it is in. Collective. Throws UserError for another stage, and if
  /// there is an output folder.
  void restore(const Saved& saved);

  /// The stage in force, or the last one. Throws UserError after the next one has failed to begin.
  [[nodiscard]] StageRun& stage() const;
  /// What the stages came to that have ended, by name.
  [[nodiscard]] const std::vector<std::pair<std::string, record::Summary>>& summaries() const { return summaries_; }
  /// Those that may be put in place from outside; null if the options name none.
  [[nodiscard]] setup::DrivenObstacles* obstacles() { return options_.obstacles.get(); }

 private:
  void open_stage(std::size_t number);
  void use_modes(std::size_t number);
  void begin_anew(std::size_t number);
  [[nodiscard]] bool go_on();
  void end_stage();

  input::Case case_;
  record::RunOptions options_;
  std::shared_ptr<const mesh::SurfaceMesh> mesh_;
  std::vector<Stage> stages_;
  std::vector<std::shared_ptr<const mesh::SurfaceMesh>> meshes_;  ///< of the case, as the stages find it
  Origin origin_ = Origin::nothing;
  results::Checkpoint state_;                   ///< with which the stage to come begins; rank 0
  setup::StageModes modes_;                     ///< that no file holds; rank 0
  std::optional<record::OutputFolder> folder_;  ///< rank 0
  std::vector<std::pair<std::string, record::Summary>> summaries_;
  std::vector<double> forces_;  ///< from outside, which go on into the stage to come; rank 0
  std::size_t number_ = 0;
  std::unique_ptr<StageRun> stage_;
};

}  // namespace voile::simulation

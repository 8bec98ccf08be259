// States between models, as a checkpoint holds them: three values per vertex, global axes, mesh order, on rank 0.
#pragma once

#include <chrono>
#include <filesystem>

#include "input/case.hpp"
#include "results/checkpoint.hpp"
#include "system/model.hpp"
#include "system/state.hpp"

namespace voile::remesh {

/// Collective.
[[nodiscard]] results::Checkpoint gather(const system::State& state, const system::Model& model);
/// With the contact forces that the next stage finds. Collective.
[[nodiscard]] results::Checkpoint gather_end(const system::State& state, const system::Model& model);
/// With what a model needs to go on in the same way: couplings of contact, the start of the last step. Collective.
[[nodiscard]] results::Checkpoint gather_whole(const system::State& state, const system::Model& model);
/// Numbers and what contact remembers must be the same on all ranks. Collective.
[[nodiscard]] system::State scatter(const results::Checkpoint& from, const system::Dofs& dofs);

/// Writes checkpoint.h5 when it is due or asked for.
class Checkpoints {
 public:
  /// `folder` empty: nothing is written.
  Checkpoints(const input::Case& c, const std::filesystem::path& folder);

  /// `asked`: by a signal. Collective.
  void after_step(const system::State& s, const system::Model& model, bool asked);
  /// `at_end`: of a stage, with the contact forces there. Collective.
  void write(const system::State& s, const system::Model& model, bool at_end = false);
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  using Clock = std::chrono::steady_clock;
  int every_;
  double minutes_;
  std::filesystem::path file_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace voile::remesh

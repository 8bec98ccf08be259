// Runs of cases side by side, each in a folder of its own.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "voile/errors.hpp"

namespace voile::cli {

/// The case.toml of a folder; `voile run` writes into its `results`, and what it prints into run.log.
struct CaseJob {
  std::filesystem::path folder;
  std::filesystem::path restart{};         ///< file to continue from; empty: none
  std::function<void()> write;             ///< the case, just before it is run
  std::function<void(bool success)> read;  ///< what came of it: exit code 0 or not
};

/// What a signal ends a test with, so that what is temporary is removed.
struct StoppedBySignal {};
/// Says so. Exit code 3, as of a run.
[[nodiscard]] Exit stopped_by_signal();

/// Runs all, so many side by side; 0: one for each core. Throws StoppedBySignal, UserError.
void run_side_by_side(const std::vector<CaseJob>& jobs, int side_by_side);

}  // namespace voile::cli

// The stages of a run, resolved.
#pragma once

#include <optional>
#include <vector>

#include "input/case.hpp"
#include "record/run_options.hpp"
#include "remesh/epoch.hpp"
#include "remesh/stage.hpp"

namespace voile::simulation {

using remesh::Epoch;
using remesh::Origin;
using remesh::Stage;

/// A case without stages is one. Reads the files of obstacles, each once. What a support of a later stage has held
/// before stays where it is: its `value` is spent, and a motion does not go by another clock. Loads that have acted
/// before stay, where the load factor counts, at what the end of the stage before has brought them to. Collective.
/// Throws UserError.
[[nodiscard]] std::vector<Stage> stages_of(const input::Case& c, const record::RunOptions& options);

/// Takes away the stages before the one that --from names, and says what the run begins with. `options.restart` becomes
/// the end of the stage before where nothing else is named. Throws UserError.
[[nodiscard]] Origin begin_from(const input::Case& c, record::RunOptions& options, std::vector<Stage>& stages);

/// Throws UserError if a stage holds things at another load factor than the one that the path before it has reached.
void require_factor(const Stage& stage, double reached);

}  // namespace voile::simulation

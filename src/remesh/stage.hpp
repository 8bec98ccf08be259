// One stage of a run, as its epochs and remeshings need it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "input/case.hpp"
#include "record/run_options.hpp"
#include "system/model.hpp"

namespace voile::remesh {

/// One stage, with what PETSc's options say in force.
struct Stage {
  input::Case c;
  record::RunOptions options;  ///< with the folder of the stage
  system::ModelInput input;
  std::vector<char> frozen;                ///< per support: in this stage it no longer moves
  std::vector<char> in_time{};             ///< per support: it moves in time, or has done so before
  std::vector<char> unmoved{};             ///< per support: only stages of modes have had it, which have not moved it
  std::vector<char> unmoved_pairs{};       ///< likewise per pair of periodic edges
  std::vector<char> rigid_in_time{};       ///< likewise per rigid group
  std::vector<std::string> sewn_before{};  ///< seams that earlier stages have closed
  std::optional<double> held_at{};  ///< load factor of the path before at which something is held; absent: nothing is
};

}  // namespace voile::remesh

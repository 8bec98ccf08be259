// Where supports hold the sheet, against where mesh.start has it.
#pragma once

#include "input/case.hpp"
#include "system/model.hpp"

namespace voile::setup {

/// Prints a note where supports begin by pulling the sheet away from `start`, the state of mesh.start, as [mesh] file has
/// it elsewhere; nothing without mesh.start. Collective. Throws UserError beyond the size of a cell.
void check_start_supports(const input::Case& c, system::Model& model, Vec start);

}  // namespace voile::setup

// The start of a run with contact: nothing may intersect in it.
#pragma once

#include "base/petsc.hpp"
#include "input/case.hpp"
#include "record/run_options.hpp"

namespace voile::system {
class Contact;
}  // namespace voile::system

namespace voile::simulation {

/// What `check` finds of the start: throws UserError as settle_start does, but only says what untangle is there for,
/// and prints notes. Collective.
void examine_start(const input::Case& c, system::Contact& contact, Vec a);

/// Checks the state a with the obstacles where they are at `time` [s]. With [contact] untangle, where the run begins
/// (`is_first`), a start that intersects is repaired first: the free components of a change. Collective. Throws
/// UserError with a full report if something intersects, or is nearer than thicknesses allow.
void settle_start(const input::Case& c, const record::RunOptions& options, system::Contact& contact, Vec a, double time,
                  bool is_first);

}  // namespace voile::simulation

#include "voile/app/run.hpp"

#include "case_run.hpp"
#include "voile/base/interrupt.hpp"
#include "voile/base/petsc.hpp"

namespace voile::app {

namespace {

/// --verbose shows every Newton iteration, exactly as -snes_monitor does.
void show_iterations() {
  PetscBool given = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-snes_monitor", &given));
  if (!given) VOILE_PETSC(PetscOptionsSetValue(nullptr, "-snes_monitor", nullptr));
}

}  // namespace

Exit run(const input::Case& c, const RunOptions& options) {
  const SignalScope signals;
  if (options.verbosity == Verbosity::verbose) show_iterations();
  CaseRun run(c, options);
  while (!run.finished()) run.advance();
  return run.finish();
}

}  // namespace voile::app

#include "run.hpp"

#include <string>

#include "base/interrupt.hpp"
#include "base/petsc.hpp"
#include "base/terminal.hpp"
#include "case_run.hpp"

namespace voile::simulation {

namespace {

/// --verbose shows every Newton iteration, exactly as -snes_monitor does.
void show_iterations() {
  PetscBool given = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-snes_monitor", &given));
  if (!given) VOILE_PETSC(PetscOptionsSetValue(nullptr, "-snes_monitor", nullptr));
}

/// Whether an option of PETSc prints lines of its own between ours.
bool monitors() {
  char* all = nullptr;
  VOILE_PETSC(PetscOptionsGetAll(nullptr, &all));
  const bool found = std::string(all).find("_monitor") != std::string::npos;
  VOILE_PETSC(PetscFree(all));
  return found;
}

}  // namespace

Exit run(const input::Case& c, const record::RunOptions& options) {
  const SignalScope signals;
  if (options.verbosity == record::Verbosity::verbose) show_iterations();
  if (monitors()) use_plain_output(true);
  CaseRun run(c, options);
  while (!run.finished()) run.advance();
  return run.finish();
}

}  // namespace voile::simulation

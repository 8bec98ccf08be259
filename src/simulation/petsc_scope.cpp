#include "petsc_scope.hpp"

#include "base/petsc.hpp"
#include "input/command_line.hpp"

namespace voile {

PetscOptionsOf::PetscOptionsOf(const std::string& of_case, const std::string& own) {
  VOILE_PETSC(PetscOptionsCreate(&options_));
  char* all = nullptr;
  VOILE_PETSC(PetscOptionsGetAll(nullptr, &all));
  const std::string of_process = all;
  VOILE_PETSC(PetscFree(all));
  for (const std::string& options : {of_case, of_process, own}) insert(options);
}

void PetscOptionsOf::insert(const std::string& options) {
  for (const auto& [name, value] : input::petsc_pairs(options))
    VOILE_PETSC(PetscOptionsSetValue(options_, name.c_str(), value.empty() ? nullptr : value.c_str()));
}

PetscOptionsOf::~PetscOptionsOf() {
  if (!petsc_has_ended()) (void)PetscOptionsDestroy(&options_);
}

PetscOptionsOf::Scope::Scope(PetscOptionsOf& of) : of_(of) {
  if (of_.depth_++ > 0) return;
  VOILE_PETSC(PetscOptionsPush(of_.options_));
  petsc::collect_errors();
}

PetscOptionsOf::Scope::~Scope() {
  if (--of_.depth_ > 0) return;
  (void)PetscPopErrorHandler();
  (void)PetscOptionsPop();
}

bool petsc_has_ended() {
  PetscBool ended = PETSC_FALSE;
  (void)PetscFinalized(&ended);
  return ended == PETSC_TRUE;
}

}  // namespace voile

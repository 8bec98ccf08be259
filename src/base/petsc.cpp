#include "petsc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string>

#include "voile/errors.hpp"

namespace voile::petsc {

namespace {

/// What PETSc said of the error that it is returning from.
struct LastError {
  std::string text;         ///< where it arose
  std::string function;     ///< of PETSc, where it arose
  std::string stack;        ///< functions it has come through
  PetscErrorCode code = 0;  ///< PETSc's malloc returns another one than it raises
} last_error;

std::exception_ptr thrown;  ///< by a callback of PETSc, which is returning from it

PetscErrorCode remember(MPI_Comm, int line, const char* function, const char*, PetscErrorCode code, PetscErrorType type,
                        const char* text, void*) {
  if (type == PETSC_ERROR_INITIAL) last_error = {text ? text : "", function ? function : "", "", code};
  last_error.stack += fmt::format(" < {}:{}", function ? function : "?", line);
  return code;
}

/// Whether an error came up in a solver that options have chosen.
bool is_of_chosen_solver(const LastError& error) {
  char* all = nullptr;
  if (PetscOptionsGetAll(nullptr, &all) != 0) return false;
  const std::string options(all);
  (void)PetscFree(all);
  const auto has = [](const std::string& text, std::initializer_list<const char*> words) {
    return std::any_of(words.begin(), words.end(), [&](const char* w) { return text.find(w) != std::string::npos; });
  };
  return has(options, {"-ksp_type", "-ksp_initial_guess", "-pc_", "-mat_mumps_", "-st_"}) &&
         has(error.function + error.stack, {"KSPSolve", "KSPSetUp", "PCSetUp", "PCApply"});
}

/// Whether options that PETSc cannot follow are behind an error.
bool is_of_options(PetscErrorCode code, const LastError& error) {
  switch (code) {
    case PETSC_ERR_ARG_UNKNOWN_TYPE:  // -snes_type, -pc_type ...
    case PETSC_ERR_MISSING_FACTOR:    // -pc_factor_mat_solver_type
    case PETSC_ERR_SUP:               // what the type of matrix does not have
    case PETSC_ERR_SUP_SYS:
    case PETSC_ERR_FILE_OPEN:  // -options_file, viewers
    case PETSC_ERR_FILE_WRITE:
    case PETSC_ERR_USER_INPUT:
      return true;
    default:
      return error.function.starts_with("PetscOptions") || error.function.find("SetFromOptions") != std::string::npos ||
             error.stack.find("SetFromOptions") != std::string::npos || error.function.starts_with("ask_options");
  }
}

}  // namespace

void collect_errors() {
  check(PetscPushErrorHandler(remember, nullptr), "PetscPushErrorHandler");
}

PetscErrorCode keep_exception() noexcept {
  thrown = std::current_exception();
  return PETSC_ERR_LIB;
}

void check(PetscErrorCode code, const char* where) {
  if (code == 0) return;
  const LastError error = std::exchange(last_error, {});
  if (thrown) std::rethrow_exception(std::exchange(thrown, nullptr));
  const char* general = nullptr;
  PetscErrorMessage(code, &general, nullptr);
  const std::string what = error.text.empty() ? (general ? general : "unknown") : error.text;
  if (error.code == PETSC_ERR_MEM || error.function.starts_with("PetscMalloc"))
    throw OutOfMemory(fmt::format("an array of the linear algebra could not be had in {}", where));
  if (error.code == PETSC_ERR_NOT_CONVERGED)  // of solvers that options choose
    throw UserError(
        fmt::format("a linear system has not been solved: {}; leave out options of linear solvers (-st_ksp_type, "
                    "-st_pc_type ...) or let them iterate longer",
                    what));
  if (is_of_options(code, error) || is_of_chosen_solver(error))
    throw UserError(fmt::format(
        "PETSc refuses one of its options: {} (in {}); see the options on the command line, in PETSC_OPTIONS and in "
        "[petsc] of the case, and -help for what is known",
        what, error.function));
  throw InternalError(fmt::format("PETSc error {} ({}) in {}{}", static_cast<int>(code), what, where, error.stack));
}

const Events& events() {
  static const Events registered = [] {
    PetscClassId id = 0;
    Events e{};
    check(PetscClassIdRegister("Voile", &id), "PetscClassIdRegister");
    const auto add = [&](const char* name, PetscLogEvent& event) {
      check(PetscLogEventRegister(name, id, &event), "PetscLogEventRegister");
    };
    add("VoileResidual", e.residual);
    add("VoileTangent", e.tangent);
    add("VoileBendAssemble", e.bending_assemble);
    add("VoileBendCopy", e.bending_copy);
    add("VoileEnergy", e.energy);
    add("VoileOutput", e.output);
    add("VoileRemesh", e.remesh);
    add("VoileContactFind", e.contact_find);
    add("VoileContactClear", e.contact_clear);
    add("VoileContactTerm", e.contact_term);
    add("VoileFactorSingle", e.factor_single);
    add("VoileRefine", e.refine);
    add("VoileFactorIncomplete", e.incomplete_factor);
    add("VoileIterate", e.iterate);
    return e;
  }();
  return registered;
}

}  // namespace voile::petsc

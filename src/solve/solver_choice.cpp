#include "solver_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "base/petsc.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

namespace {

/// Methods that solve such problems with residual and tangent alone; measured on all that PETSc 3.18 has, the others do not
/// converge here, or need meshes, bounds or functions of their own.
constexpr std::array<std::string_view, 5> methods = {SNESNEWTONLS, SNESNEWTONTR, SNESNEWTONTRDC, SNESQN, SNESKSPONLY};
/// Line searches that never take more than the increment they are given.
constexpr std::array<std::string_view, 4> bounded_searches = {SNESLINESEARCHSHELL, SNESLINESEARCHBASIC,
                                                              SNESLINESEARCHBT, SNESLINESEARCHNLEQERR};

/// Options that would take the judgement of convergence, the tangent or the residual out of our hands.
constexpr std::array<const char*, 9> refused = {"-snes_convergence_test",
                                                "-snes_mf",
                                                "-snes_mf_operator",
                                                "-snes_fd",
                                                "-snes_fd_color",
                                                "-snes_force_iteration",
                                                "-snes_skip_converged",
                                                "-npc_snes_type",
                                                "-snes_ksp_ew"};

template <class List>
bool is_in(const List& list, const char* word) {
  return std::find(list.begin(), list.end(), std::string_view(word)) != list.end();
}

}  // namespace

void refuse_snes_options() {
  for (const char* option : refused) {
    PetscBool given = PETSC_FALSE;
    VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, option, &given));
    if (given)
      throw UserError(fmt::format(
          "option {}: Voile judges convergence itself, with its own residual and tangent; leave the option out",
          option));
  }
  std::array<char, 64> type{};
  PetscBool given = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsGetString(nullptr, nullptr, "-snes_type", type.data(), type.size(), &given));
  if (given && !is_in(methods, type.data()))
    throw UserError(
        fmt::format("option -snes_type {}: does not solve such problems; newtonls (the default), newtontr, "
                    "newtontrdc, qn and ksponly are possible",
                    type.data()));
  VOILE_PETSC(PetscOptionsGetString(nullptr, nullptr, "-snes_linesearch_type", type.data(), type.size(), &given));
  if (given && std::string_view(type.data()) == SNESLINESEARCHSHELL)
    throw UserError(
        "option -snes_linesearch_type shell: needs a function of a program; bt, l2, cp, basic and nleqerr are "
        "possible");
}

void SolverChoice::read(SNES snes, bool contact) {
  SNESType type = nullptr;
  SNESLineSearch search = nullptr;
  SNESLineSearchType search_type = nullptr;
  PetscInt lag = 1, lag_preconditioner = 1;
  PetscBool preconditioned = PETSC_FALSE;
  VOILE_PETSC(SNESGetType(snes, &type));
  VOILE_PETSC(SNESGetLagJacobian(snes, &lag));
  VOILE_PETSC(SNESGetLagPreconditioner(snes, &lag_preconditioner));
  VOILE_PETSC(SNESHasNPC(snes, &preconditioned));
  const bool line_search = std::string_view(type) == SNESNEWTONLS;
  if (contact && (!line_search || preconditioned))
    throw UserError(
        fmt::format("option -snes_type {}: with contact only newtonls (the default) can be held back where "
                    "the sheet would pass through something",
                    type));
  if (line_search) {
    VOILE_PETSC(SNESGetLineSearch(snes, &search));
    VOILE_PETSC(SNESLineSearchGetType(search, &search_type));
    if (contact && !is_in(bounded_searches, search_type))
      throw UserError(
          fmt::format("option -snes_linesearch_type {}: with contact basic, bt and nleqerr are possible, "
                      "which never go further than the increment",
                      search_type));
  }
  newton_ = line_search && !preconditioned && lag == 1;
  current_ = lag == 1 && lag_preconditioner == 1;
}

}  // namespace voile::solve

// PETSc as one simulation wants it, for the time of a call: its own options, and errors that become exceptions; private to
// src/simulation.
#pragma once

#include <petscsys.h>

#include <string>

namespace voile {

/// Options of one simulation: those of [petsc] in its case, over which the process's options win, and its own, which win over
/// both.
class PetscOptionsOf {
 public:
  PetscOptionsOf(const std::string& of_case, const std::string& own);
  ~PetscOptionsOf();
  PetscOptionsOf(const PetscOptionsOf&) = delete;
  PetscOptionsOf& operator=(const PetscOptionsOf&) = delete;

  /// In force while it lives; scopes of one simulation within each other count once.
  class Scope {
   public:
    explicit Scope(PetscOptionsOf& of);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    PetscOptionsOf& of_;
  };

 private:
  void insert(const std::string& options);
  PetscOptions options_ = nullptr;
  int depth_ = 0;
};

/// Whether PETSc has been ended: what is left of it cannot be destroyed.
[[nodiscard]] bool petsc_has_ended();

}  // namespace voile

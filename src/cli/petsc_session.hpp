// PETSc and SLEPc as a run uses them: options of the case, of the environment and of the command line, in this order.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solve/eigen_options.hpp"

namespace voile::cli {

/// PETSc between construction and destruction. MPI has begun; all is collective over MPI_COMM_WORLD.
class PetscSession {
 public:
  /// `words`: PETSc's of the command line. Options of a .petscrc count only if they ask for it.
  PetscSession(const char* program, const std::vector<std::string>& words, const std::string& case_options);
  ~PetscSession();
  PetscSession(const PetscSession&) = delete;
  PetscSession& operator=(const PetscSession&) = delete;

  /// Throws UserError for tolerances and limits below zero, which PETSc takes silently.
  static void check_tolerances();
  /// Warns on rank 0 about options that nothing asked for, unless -options_left makes PETSc do so.
  static void report_unused_options();

 private:
  std::vector<std::string> words_;
  std::vector<char*> pointers_;
  int count_ = 0;
  char** argv_ = nullptr;
  std::optional<solve::SlepcSession> slepc_;
};

}  // namespace voile::cli

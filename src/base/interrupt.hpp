// Requests from outside while a run goes on.
//
// SIGUSR1 asks for a checkpoint; SIGINT (Ctrl-C), SIGTERM and SIGUSR2 ask for the last good state and the end of the run.
// They are noticed between the iterations of Newton's method. A second SIGINT ends the process at once. Open MPI's
// mpirun keeps SIGINT and SIGTERM for itself, kills the ranks and ends with code 1; SIGUSR2 it hands on.
#pragma once

#include <csignal>
#include <exception>

#include "mpi.hpp"

namespace voile {

/// Thrown on all ranks where a run is asked to stop between two iterations.
class Interrupted : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "stopped by a signal"; }
};

/// Takes the signals over from PETSc and MPI while it lives. One at a time.
class SignalScope {
 public:
  SignalScope();
  ~SignalScope();
  SignalScope(const SignalScope&) = delete;
  SignalScope& operator=(const SignalScope&) = delete;

  /// Whether any rank was asked to stop since the scope began; false where there is no scope. Collective.
  [[nodiscard]] static bool stop_asked(MPI_Comm comm);
  /// Whether any rank was asked for a checkpoint since the last call. Collective.
  [[nodiscard]] static bool take_checkpoint(MPI_Comm comm);

 private:
  using Handler = void (*)(int);
  Handler old_interrupt_, old_terminate_, old_user_, old_second_user_;
};

/// Throws Interrupted on all ranks if any of them was asked to stop. Collective.
void stop_if_asked(MPI_Comm comm);

}  // namespace voile

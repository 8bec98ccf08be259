// Requests from outside while a run goes on; private to src/app.
#pragma once

namespace voile::app {

/// SIGUSR1 asks for a checkpoint, SIGTERM for a checkpoint and the end of the run, after the step in progress.
struct Requests {
  bool checkpoint = false, stop = false;
};

/// Takes the two signals over from PETSc while it lives.
class SignalScope {
 public:
  SignalScope();
  ~SignalScope();
  SignalScope(const SignalScope&) = delete;
  SignalScope& operator=(const SignalScope&) = delete;
  /// What any rank was asked for since the last call. Collective.
  [[nodiscard]] static Requests take();
};

}  // namespace voile::app

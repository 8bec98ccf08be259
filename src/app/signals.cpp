#include "signals.hpp"

#include <petscsys.h>

#include <csignal>

#include "voile/base/mpi.hpp"

namespace voile::app {

namespace {

volatile std::sig_atomic_t checkpoint_asked = 0, stop_asked = 0;

void remember(int signal) {
  (signal == SIGTERM ? stop_asked : checkpoint_asked) = 1;
}

using Handler = void (*)(int);
Handler old_term = SIG_DFL, old_user = SIG_DFL;

}  // namespace

SignalScope::SignalScope() {
  checkpoint_asked = 0;
  stop_asked = 0;
  old_term = std::signal(SIGTERM, remember);
  old_user = std::signal(SIGUSR1, remember);
}

SignalScope::~SignalScope() {
  std::signal(SIGTERM, old_term);
  std::signal(SIGUSR1, old_user);
}

Requests SignalScope::take() {
  const double code = mpi::max(PETSC_COMM_WORLD, 2.0 * stop_asked + 1.0 * checkpoint_asked);
  Requests r;
  r.stop = code >= 2.0;
  r.checkpoint = code >= 1.0;
  checkpoint_asked = 0;
  stop_asked = 0;
  return r;
}

}  // namespace voile::app

#include "interrupt.hpp"

#include "mpi.hpp"

namespace voile {

namespace {

volatile std::sig_atomic_t checkpoint_asked = 0, stop_asked_here = 0;
bool active = false;

extern "C" void remember(int signal) {
  if (signal == SIGUSR1) {
    checkpoint_asked = 1;
    return;
  }
  // Whoever asks for it twice does not want to wait for the end of an iteration.
  if (signal == SIGINT && stop_asked_here == 1) {
    std::signal(SIGINT, SIG_DFL);
    std::raise(SIGINT);
  }
  stop_asked_here = 1;
}

bool any(MPI_Comm comm, bool here) {
  return mpi::max(comm, here ? 1.0 : 0.0) > 0.0;
}

}  // namespace

SignalScope::SignalScope() {
  checkpoint_asked = 0;
  stop_asked_here = 0;
  old_interrupt_ = std::signal(SIGINT, remember);
  old_terminate_ = std::signal(SIGTERM, remember);
  old_user_ = std::signal(SIGUSR1, remember);
  old_second_user_ = std::signal(SIGUSR2, remember);
  active = true;
}

SignalScope::~SignalScope() {
  active = false;
  std::signal(SIGINT, old_interrupt_);
  std::signal(SIGTERM, old_terminate_);
  std::signal(SIGUSR1, old_user_);
  std::signal(SIGUSR2, old_second_user_);
}

bool SignalScope::stop_asked(MPI_Comm comm) {
  return active && any(comm, stop_asked_here != 0);
}

bool SignalScope::take_checkpoint(MPI_Comm comm) {
  if (!active || !any(comm, checkpoint_asked != 0)) return false;
  checkpoint_asked = 0;
  return true;
}

void stop_if_asked(MPI_Comm comm) {
  if (SignalScope::stop_asked(comm)) throw Interrupted();
}

}  // namespace voile

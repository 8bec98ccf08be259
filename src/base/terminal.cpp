#include "voile/base/terminal.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>

namespace voile {

namespace {

bool lost[3] = {false, false, false};  // by descriptor

/// Writes all of it, or notes that it could not; says that it has done so in either case.
ssize_t write_or_lose(void* stream, const char* text, std::size_t size) {
  const auto descriptor = static_cast<int>(reinterpret_cast<std::intptr_t>(stream));
  for (std::size_t done = 0; done < size;) {
    const ssize_t count = write(descriptor, text + done, size - done);
    if (count > 0) {
      done += static_cast<std::size_t>(count);
    } else if (count < 0 && errno == EAGAIN) {  // a terminal that another program has made non-blocking
      pollfd one{descriptor, POLLOUT, 0};
      (void)poll(&one, 1, 1000);
    } else if (count == 0 || errno != EINTR) {
      lost[descriptor] = true;
      break;
    }
  }
  return static_cast<ssize_t>(size);
}

void keep(int descriptor, FILE*& stream, int buffering) {
  if (fcntl(descriptor, F_GETFD) < 0) {
    // The lowest free number, which is this one.
    if (open("/dev/null", O_RDWR) != descriptor) return;
    if (descriptor == STDOUT_FILENO) lost[descriptor] = true;
  }
  if (descriptor == STDIN_FILENO) return;
  FILE* keeping = fopencookie(reinterpret_cast<void*>(static_cast<std::intptr_t>(descriptor)), "w",
                              {nullptr, write_or_lose, nullptr, nullptr});
  if (!keeping) return;
  (void)std::setvbuf(keeping, nullptr, buffering, buffering == _IONBF ? 0 : BUFSIZ);
  stream = keeping;
}

}  // namespace

void keep_output_streams() {
  (void)std::signal(SIGXFSZ, SIG_IGN);
  keep(STDIN_FILENO, stdin, _IONBF);
  keep(STDOUT_FILENO, stdout, isatty(STDOUT_FILENO) != 0 ? _IOLBF : _IOFBF);
  keep(STDERR_FILENO, stderr, _IONBF);
}

bool output_was_lost() {
  (void)std::fflush(stdout);
  return lost[STDOUT_FILENO];
}

}  // namespace voile

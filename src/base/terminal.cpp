#include "voile/base/terminal.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>

namespace voile {

namespace {

struct Stream {
  int descriptor;
  bool lost = false;
};
Stream output{STDOUT_FILENO}, errors{STDERR_FILENO};

/// Writes all of it, or notes that it could not; says that it has done so in either case.
ssize_t write_or_lose(void* cookie, const char* text, std::size_t size) {
  Stream& stream = *static_cast<Stream*>(cookie);
  for (std::size_t done = 0; done < size;) {
    const ssize_t count = write(stream.descriptor, text + done, size - done);
    if (count > 0) {
      done += static_cast<std::size_t>(count);
    } else if (count < 0 && errno == EAGAIN) {  // a terminal that another program has made non-blocking
      pollfd one{stream.descriptor, POLLOUT, 0};
      (void)poll(&one, 1, 1000);
    } else if (count == 0 || errno != EINTR) {
      stream.lost = true;
      break;
    }
  }
  return static_cast<ssize_t>(size);
}

/// What is closed leads nowhere: who closes it wants to see nothing.
void open_if_closed(int descriptor) {
  if (fcntl(descriptor, F_GETFD) < 0) (void)open("/dev/null", O_RDWR);  // the lowest free number, which is this one
}

void keep(Stream& stream, FILE*& file, int buffering) {
  open_if_closed(stream.descriptor);
  FILE* keeping = fopencookie(&stream, "w", {nullptr, write_or_lose, nullptr, nullptr});
  if (!keeping) return;
  (void)std::setvbuf(keeping, nullptr, buffering, buffering == _IONBF ? 0 : BUFSIZ);
  file = keeping;
}

}  // namespace

void keep_output_streams() {
  (void)std::signal(SIGXFSZ, SIG_IGN);
  open_if_closed(STDIN_FILENO);
  keep(output, stdout, isatty(STDOUT_FILENO) != 0 ? _IOLBF : _IOFBF);
  keep(errors, stderr, _IONBF);
}

bool output_was_lost() {
  (void)std::fflush(stdout);
  return output.lost;
}

}  // namespace voile

#include "terminal.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace voile {

namespace {

struct Stream {
  int descriptor;
  bool lost = false;
  bool colours = false;
  bool at_line_start = true;
};
Stream output{STDOUT_FILENO}, errors{STDERR_FILENO};

/// The line of progress.
struct ProgressLine {
  bool allowed = false, shown = false;
  std::chrono::steady_clock::time_point last{};
};
ProgressLine progress;

constexpr std::chrono::milliseconds between_lines{100};
constexpr std::size_t usual_width = 80;
constexpr std::string_view erase_line = "\r\033[K", end_of_colour = "\033[0m", prefix = "voile: ";

struct Word {
  std::string_view word, colour;
};
constexpr std::array words{Word{"error:", "\033[1;31m"}, Word{"internal error:", "\033[1;31m"},
                           Word{"not converged:", "\033[1;31m"}, Word{"warning:", "\033[1;35m"}};

/// Writes all of it, or notes that it could not.
void write_or_lose(Stream& stream, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = write(stream.descriptor, text.data(), text.size());
    if (count > 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (count < 0 && errno == EAGAIN) {  // a terminal that another program has made non-blocking
      pollfd one{stream.descriptor, POLLOUT, 0};
      (void)poll(&one, 1, 1000);
    } else if (count == 0 || errno != EINTR) {
      stream.lost = true;
      break;
    }
  }
}

void erase_progress() {
  if (std::exchange(progress.shown, false)) write_or_lose(output, erase_line);
}

/// Says that it has written all in any case.
ssize_t print(void* cookie, const char* text, std::size_t size) {
  Stream& stream = *static_cast<Stream*>(cookie);
  if (size == 0) return 0;
  erase_progress();
  if (stream.colours)
    write_or_lose(stream, coloured({text, size}, stream.at_line_start));
  else
    write_or_lose(stream, {text, size});
  stream.at_line_start = text[size - 1] == '\n';
  return static_cast<ssize_t>(size);
}

/// What is closed leads nowhere: who closes it wants to see nothing.
void open_if_closed(int descriptor) {
  if (fcntl(descriptor, F_GETFD) < 0) (void)open("/dev/null", O_RDWR);  // the lowest free number, which is this one
}

void keep(Stream& stream, FILE*& file, int buffering) {
  open_if_closed(stream.descriptor);
  FILE* keeping = fopencookie(&stream, "w", {nullptr, print, nullptr, nullptr});
  if (!keeping) return;
  (void)std::setvbuf(keeping, nullptr, buffering, buffering == _IONBF ? 0 : BUFSIZ);
  file = keeping;
}

bool is_set(const char* name) {
  const char* value = std::getenv(name);
  return value && *value != '\0';
}

std::size_t terminal_width() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : usual_width;
}

}  // namespace

void keep_output_streams() {
  (void)std::signal(SIGXFSZ, SIG_IGN);
  open_if_closed(STDIN_FILENO);
  keep(output, stdout, isatty(STDOUT_FILENO) != 0 ? _IOLBF : _IOFBF);
  keep(errors, stderr, _IONBF);
  const bool capable = is_set("TERM") && std::string_view(std::getenv("TERM")) != "dumb" && !is_set("NO_COLOR");
  output.colours = progress.allowed = capable && isatty(STDOUT_FILENO) != 0;
  errors.colours = capable && isatty(STDERR_FILENO) != 0;
}

bool output_was_lost() {
  (void)std::fflush(stdout);
  return output.lost;
}

void use_plain_output(bool colours) {
  erase_progress();
  progress.allowed = false;
  if (!colours) output.colours = errors.colours = false;
}

bool rewrites_progress() {
  return progress.allowed;
}

void show_progress(const std::string& text) {
  const auto now = std::chrono::steady_clock::now();
  if (!progress.allowed || (progress.shown && now - progress.last < between_lines)) return;
  (void)std::fflush(stdout);
  if (!output.at_line_start || !errors.at_line_start) return;
  progress.last = now;
  progress.shown = true;
  // The last column stays free: a full line would move to the next one.
  write_or_lose(output, std::string(erase_line) + text.substr(0, terminal_width() - 1));
}

std::string coloured(const std::string& text, bool at_start) {
  std::string out;
  for (std::size_t begin = 0; begin < text.size(); at_start = true) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end;
    if (at_start) {
      const bool ours = line.starts_with(prefix);
      const std::string_view rest = ours ? line.substr(prefix.size()) : line;
      const auto* const found =
          std::find_if(words.begin(), words.end(), [&](const Word& w) { return rest.starts_with(w.word); });
      if (found != words.end()) {
        out.append(ours ? prefix : "").append(found->colour).append(found->word).append(end_of_colour);
        line = rest.substr(found->word.size());
      }
    }
    out += line;
  }
  return out;
}

}  // namespace voile

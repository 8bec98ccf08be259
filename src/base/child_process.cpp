#include "child_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

#include "confinement.hpp"
#include "shipped_files.hpp"
#include "voile/errors.hpp"

namespace voile {

namespace {

/// First byte of what the child sends.
enum class Answer : char { done = 'd', user_error = 'u', no_memory = 'm', failed = 'f', program = 'p', file = 'w' };

/// A number of kB in a file of /proc, in bytes; 0 if it is not there.
std::size_t kilobytes_of(const char* file, const std::string& name) {
  std::ifstream in(file);
  std::string word;
  while (in >> word) {
    std::size_t kilobytes = 0;
    if (word == name && in >> kilobytes) return 1024 * kilobytes;
  }
  return 0;
}

/// The child may take half of what the machine has left, so that a wrong number in a file does not stop the machine;
/// what needs more for its mesh cannot be solved on it either.
void limit_memory() {
  const std::size_t have = kilobytes_of("/proc/self/status", "VmSize:"),
                    left = kilobytes_of("/proc/meminfo", "MemAvailable:");
  rlimit limit{};
  if (have == 0 || left == 0 || getrlimit(RLIMIT_AS, &limit) != 0) return;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, have + left / 2);
  (void)setrlimit(RLIMIT_AS, &limit);
}

/// Nothing of the parent's is touched: no handlers, no output, no core file, no life of its own. It ends by SIGALRM if it
/// takes too long, also where it waits for a lock that another thread of the parent held.
void become_child() {
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int number : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGALRM, SIGSYS})
    (void)std::signal(number, SIG_DFL);
  // Those are for the run, which whole groups of processes get them with; it ends this child by its own end.
  for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGUSR2}) (void)std::signal(number, SIG_IGN);
  (void)alarm(static_cast<unsigned>(limit_of_reading()));
  const rlimit no_core{0, 0};
  (void)setrlimit(RLIMIT_CORE, &no_core);
  limit_memory();
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) (void)dup2(nowhere, stream);
}

void write_all(int descriptor, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t written = write(descriptor, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // the parent has gone
    bytes += written;
    count -= static_cast<std::size_t>(written);
  }
}

int answer_descriptor = -1;      // of the child, for its handlers below
volatile bool answered = false;  // it has sent, or is sending
bool lasting = false;            // more answers follow, so that each says how long it is

void send(int descriptor, Answer answer, const std::string& bytes) {
  answered = true;
  const char first = static_cast<char>(answer);
  const std::size_t count = bytes.size();
  write_all(descriptor, &first, 1);
  if (lasting) write_all(descriptor, reinterpret_cast<const char*>(&count), sizeof count);
  write_all(descriptor, bytes.data(), count);
}

/// Before bad_alloc: libraries run into std::terminate with it.
void out_of_memory() {
  const char answer = static_cast<char>(Answer::no_memory);
  write_all(answer_descriptor, &answer, 1);
  _exit(0);
}

/// Does the work and sends what comes of it.
void answer(int descriptor, const std::function<std::string()>& work) {
  answer_descriptor = descriptor;
  std::set_new_handler(out_of_memory);
  try {
    send(descriptor, Answer::done, work());
  } catch (const UserError& e) {
    send(descriptor, Answer::user_error, e.what());
  } catch (const std::filesystem::filesystem_error& e) {
    send(descriptor, Answer::user_error, fmt::format("{}: {}", e.path1().string(), e.code().message()));
  } catch (const std::bad_alloc&) {
    send(descriptor, Answer::no_memory, "");
  } catch (const std::length_error&) {
    send(descriptor, Answer::no_memory, "");
  } catch (const std::exception& e) {
    send(descriptor, Answer::failed, e.what());
  } catch (...) {
    send(descriptor, Answer::failed, "unknown exception");
  }
}

[[noreturn]] void child(int descriptor, const std::function<std::string()>& work) {
  become_child();
  answer(descriptor, work);
  _exit(0);
}

/// Descriptor on which a program beside this one answers.
constexpr int answer_stream = 3;

[[noreturn]] void execute(int descriptor, const std::filesystem::path& program, const std::vector<std::string>& words) {
  if (!std::getenv("VOILE_READ_HERE")) become_child();
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  if (descriptor == answer_stream)
    (void)fcntl(descriptor, F_SETFD, 0);
  else
    (void)dup2(descriptor, answer_stream);
  (void)alarm(0);  // it sets its own if it is confined
  (void)execv(program.c_str(), arguments.data());
  send(answer_stream, Answer::user_error,
       fmt::format("{}: the program cannot be started ({}); install it beside voile, or build it", program.string(),
                   std::strerror(errno)));
  _exit(0);
}

bool read_exactly(int descriptor, char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t part = read(descriptor, bytes, count);
    if (part < 0 && errno == EINTR) continue;
    if (part <= 0) return false;
    bytes += part;
    count -= static_cast<std::size_t>(part);
  }
  return true;
}

std::string read_all(int descriptor) {
  std::string bytes;
  std::string part(1 << 16, '\0');
  for (;;) {
    const ssize_t count = read(descriptor, part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return bytes;
    bytes.append(part, 0, static_cast<std::size_t>(count));
  }
}

}  // namespace

namespace {

UserError refused(const std::string& file, Refused what) {
  return UserError(fmt::format(
      "{}: it tries to {}, which reading a mesh does not need, and was stopped; remove the command, or give "
      "--allow-system-call if you trust the file and what it includes",
      file, what == Refused::program ? "run a program" : "write a file or make a folder"));
}

/// Throws if a child was ended for what it did.
void explain_signal(const std::string& file, int signal) {
  if (signal == SIGSYS) throw refused(file, Refused::program);
  if (signal == SIGXFSZ) throw refused(file, Refused::file);
  if (signal == SIGALRM)
    throw UserError(
        fmt::format("{}: reading and meshing it took more than {} s and was stopped; if it needs longer, set the "
                    "environment variable VOILE_READ_SECONDS to the seconds that it may take",
                    file, limit_of_reading()));
}

/// What a child has sent, or what it says went wrong.
std::string result_of(const std::string& file, Answer answer, std::string bytes) {
  if (answer == Answer::done) return bytes;
  if (answer == Answer::user_error) throw UserError(bytes);
  if (answer == Answer::program) throw refused(file, Refused::program);
  if (answer == Answer::file) throw refused(file, Refused::file);
  if (answer == Answer::no_memory)
    throw UserError(fmt::format(
        "{}: reading or meshing it needs more memory than there is: a count or a parameter in it is too large, "
        "or it is damaged; make the mesh coarser or export it again",
        file));
  throw UserError(fmt::format("{}: reading it failed ({}); is the file damaged? export it again", file, bytes));
}

/// Throws for a child that has ended without an answer.
[[noreturn]] void explain_end(const std::string& file, int status) {
  if (WIFSIGNALED(status)) explain_signal(file, WTERMSIG(status));
  throw UserError(
      fmt::format("{}: reading it failed ({}): the file is damaged, or asks for something that its reader cannot do; "
                  "export it again",
                  file, WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "without an answer"));
}

/// What a child, made of this process by `become`, answers.
std::string answer_of(const std::string& file, const std::function<void(int descriptor)>& become) {
  int ends[2] = {-1, -1};
  if (pipe2(ends, O_CLOEXEC) != 0) throw InternalError(fmt::format("{}: no pipe for reading it", file));
  const pid_t pid = fork();
  if (pid < 0) {
    close(ends[0]);
    close(ends[1]);
    throw InternalError(fmt::format("{}: no process for reading it: {}", file, std::strerror(errno)));
  }
  if (pid == 0) {
    close(ends[0]);
    become(ends[1]);
  }
  close(ends[1]);
  std::string bytes = read_all(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFSIGNALED(status) || bytes.empty()) explain_end(file, status);
  const auto answer = static_cast<Answer>(bytes.front());
  bytes.erase(0, 1);
  return result_of(file, answer, std::move(bytes));
}

/// What a child that stays does, until nobody asks any more.
[[noreturn]] void answer_all(int descriptor, const std::function<std::string(const std::string&)>& work) {
  become_child();
  lasting = true;
  for (;;) {
    (void)alarm(0);
    std::size_t count = 0;
    if (!read_exactly(descriptor, reinterpret_cast<char*>(&count), sizeof count)) _exit(0);
    std::string request(count, '\0');
    if (!read_exactly(descriptor, request.data(), count)) _exit(0);
    (void)alarm(static_cast<unsigned>(limit_of_reading()));
    answer(descriptor, [&] { return work(request); });
  }
}

}  // namespace

std::string run_in_child(const std::string& file, const std::function<std::string()>& work) {
  if (std::getenv("VOILE_READ_HERE")) return work();
  return answer_of(file, [&](int descriptor) { child(descriptor, work); });
}

struct LastingChild::Impl {
  std::string file;
  std::function<std::string(const std::string&)> work;
  int descriptor = -1;
  pid_t pid = -1;

  void start();
  [[nodiscard]] bool send_request(const std::string& request) const;
  /// How the child has ended; waits for it.
  int end();
};

void LastingChild::Impl::start() {
  int ends[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw InternalError(fmt::format("{}: no socket for reading it", file));
  pid = fork();
  if (pid == 0) {
    close(ends[0]);
    answer_all(ends[1], work);
  }
  close(ends[1]);
  descriptor = ends[0];
  if (pid >= 0) return;
  close(std::exchange(descriptor, -1));
  throw InternalError(fmt::format("{}: no process for reading it: {}", file, std::strerror(errno)));
}

bool LastingChild::Impl::send_request(const std::string& request) const {
  const std::size_t count = request.size();
  std::string bytes(reinterpret_cast<const char*>(&count), sizeof count);
  bytes += request;
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t sent = ::send(descriptor, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    done += static_cast<std::size_t>(sent);
  }
  return true;
}

int LastingChild::Impl::end() {
  int status = 0;
  if (pid < 0) return status;
  // Closing is not enough: children that were started later have this end, too.
  (void)shutdown(descriptor, SHUT_RDWR);
  close(std::exchange(descriptor, -1));
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
  pid = -1;
  return status;
}

LastingChild::LastingChild(std::string file, std::function<std::string(const std::string&)> work)
    : impl_(std::make_unique<Impl>(Impl{std::move(file), std::move(work)})) {}
LastingChild::~LastingChild() {
  (void)impl_->end();
}

std::string LastingChild::ask(const std::string& request) {
  Impl& n = *impl_;
  if (std::getenv("VOILE_READ_HERE")) return n.work(request);
  if (n.pid < 0) n.start();
  char first = '\0';
  if (!n.send_request(request) || !read_exactly(n.descriptor, &first, 1)) explain_end(n.file, n.end());
  const auto answer = static_cast<Answer>(first);
  std::size_t count = 0;
  if (!read_exactly(n.descriptor, reinterpret_cast<char*>(&count), sizeof count)) {
    const int status = n.end();
    if (answer == Answer::done) explain_end(n.file, status);
    return result_of(n.file, answer, "");  // without memory for more than that word
  }
  std::string bytes(count, '\0');
  if (!read_exactly(n.descriptor, bytes.data(), bytes.size())) explain_end(n.file, n.end());
  return result_of(n.file, answer, std::move(bytes));
}

std::string run_beside(const std::string& file, const std::string& program, const std::vector<std::string>& words) {
  const std::filesystem::path found = program_of_ours(program);
  return answer_of(file, [&](int descriptor) { execute(descriptor, found, words); });
}

int answer_to_parent(const std::function<std::string()>& work) {
  answer(answer_stream, work);
  return 0;
}

void end_child(Refused what) {
  const char first = static_cast<char>(what == Refused::program ? Answer::program : Answer::file);
  if (!answered) write_all(answer_descriptor, &first, 1);
  _exit(0);
}

void try_in_child(const std::string& file, const std::function<void()>& work) {
  (void)run_in_child(file, [&] {
    work();
    return std::string();
  });
}

}  // namespace voile

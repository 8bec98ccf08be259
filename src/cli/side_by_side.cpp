#include "side_by_side.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <map>
#include <string>
#include <thread>

#include "base/shipped_files.hpp"

namespace voile::cli {

namespace {

/// Starts `voile run` of a job; what it prints goes to run.log.
pid_t start(const CaseJob& job) {
  const std::string program = program_of_ours("voile").string(), log = (job.folder / "run.log").string();
  std::vector<std::string> words{
      program,      "run", (job.folder / "case.toml").string(), "--output", (job.folder / "results").string(),
      "--overwrite"};
  if (!job.restart.empty()) words.insert(words.end(), {"--restart", job.restart.string()});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw UserError(fmt::format("{}: the program cannot be started", program));
  return pid;
}

/// Runs that are going on: a signal ends them too, and no other one begins.
std::array<std::atomic<pid_t>, 128> children{};
std::atomic<bool> stopped{false};

void note_child(pid_t from, pid_t to) {
  for (std::atomic<pid_t>& child : children)
    if (pid_t was = from; child.compare_exchange_strong(was, to)) return;
}

void end_children(int) {
  stopped = true;
  for (const std::atomic<pid_t>& child : children)
    if (const pid_t pid = child.load(); pid > 0) (void)kill(pid, SIGTERM);
}

}  // namespace

Exit stopped_by_signal() {
  fmt::print(stderr, "voile: stopped by a signal\n");
  return Exit::not_converged;
}

void run_side_by_side(const std::vector<CaseJob>& jobs, int side_by_side) {
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const auto most = static_cast<std::size_t>(side_by_side > 0 ? side_by_side : cores);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) (void)std::signal(signal, end_children);
  std::map<pid_t, std::size_t> running;
  for (std::size_t next = 0; (next < jobs.size() && !stopped) || !running.empty();) {
    if (next < jobs.size() && !stopped && running.size() < most) {
      jobs[next].write();
      note_child(0, running.emplace(start(jobs[next]), next).first->first);
      ++next;
      continue;
    }
    int status = 0;
    const pid_t pid = waitpid(-1, &status, 0);
    const auto ended = running.find(pid);
    if (ended == running.end()) continue;
    note_child(pid, 0);
    if (!stopped) jobs[ended->second].read(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    running.erase(ended);
  }
  if (stopped) throw StoppedBySignal{};
}

}  // namespace voile::cli

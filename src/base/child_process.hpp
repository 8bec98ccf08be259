// Work on foreign data in a process of its own: what crashes there does not take the program with it.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace voile {

/// Runs `work` in a forked child process and returns the bytes that it made; they may be of any length.
/// The child has neither standard output nor the parent's signal handlers, gets half of the memory that the
/// machine has available, must not call MPI and ends without cleaning up. `file` is what it reads, for messages.
/// Throws UserError: what `work` threw as such; and if the child tries what a confined program may not or takes too long
/// (confinement.hpp), runs out of memory, dies of a signal or ends without a
/// result, that the file is damaged or too large. Other exceptions of `work` become UserErrors too: a foreign file made
/// its reader fail. With VOILE_READ_HERE in the environment the work is done in this process, for debuggers and
/// sanitizers. Throws InternalError if no process can be started. Not collective.
[[nodiscard]] std::string run_in_child(const std::string& file, const std::function<std::string()>& work);

/// Such a child that stays, with what it has opened, and answers one request after the other, each within the time that a
/// child has. It ends with this object, or with this process.
class LastingChild {
 public:
  /// `work`: the answer to a request; what it keeps, it keeps in the child. Starts nothing yet.
  LastingChild(std::string file, std::function<std::string(const std::string& request)> work);
  ~LastingChild();
  LastingChild(const LastingChild&) = delete;
  LastingChild& operator=(const LastingChild&) = delete;
  /// Throws as run_in_child(); the request after one that the child has died of goes to a new one.
  [[nodiscard]] std::string ask(const std::string& request);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The same by a program that lies beside this one, given `words`, which answers through answer_to_parent(). Throws
/// UserError too if there is no such program.
[[nodiscard]] std::string run_beside(const std::string& file, const std::string& program,
                                     const std::vector<std::string>& words);
/// In such a program: does the work, and sends what comes of it. Returns the exit code.
[[nodiscard]] int answer_to_parent(const std::function<std::string()>& work);

/// What a confined program (confinement.hpp) was stopped from doing.
enum class Refused { program, file };
/// Ends such a program in the middle of its work with a message that says so; from handlers of signals.
[[noreturn]] void end_child(Refused what);

/// The same for work whose result is not needed: whether it can be done at all. What passes is then done again here.
void try_in_child(const std::string& file, const std::function<void()>& work);

}  // namespace voile

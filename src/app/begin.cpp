#include "begin.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

#include "voile/base/error.hpp"
#include "voile/base/shipped_files.hpp"

namespace voile::app {

namespace {

namespace fs = std::filesystem;

/// Files of a template. Throws UserError if there are none.
std::vector<fs::path> files_of(const fs::path& from) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(from, ignored))
    if (entry.is_regular_file(ignored)) files.push_back(entry.path());
  if (files.empty())
    throw UserError(
        fmt::format("{}: the files of the template are missing; install Voile whole (cmake --install)", from.string()));
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

void run_silently(const std::string& name, std::vector<std::string> words, const fs::path& folder) {
  const std::string program = fs::absolute(program_of_ours(name)).string();
  words.insert(words.begin(), program);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t pid = 0;
  const int error = posix_spawn(&pid, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (error == 0) (void)waitpid(pid, &status, 0);
  if (error != 0 || status != 0)
    throw UserError(
        fmt::format("{}: the program cannot be started or has failed; install it beside voile, or build it", program));
}

std::string template_list() {
  std::string out = "Templates of voile init FOLDER:\n";
  for (const Template& t : templates) out += fmt::format("  --{:<8} {}\n", t.name, t.what);
  return out;
}

void begin_case(const fs::path& folder, const std::string& name) {
  const auto* const chosen =
      std::find_if(templates.begin(), templates.end(), [&](const Template& t) { return name == t.name; });
  if (chosen == templates.end()) throw UserError(fmt::format("init needs one template. {}", template_list()));
  const std::vector<fs::path> files = files_of(shipped_folder("templates") / name);
  std::error_code error;
  for (const fs::path& file : files)
    if (const fs::path to = folder / file.filename(); fs::exists(fs::symlink_status(to, error)))
      throw UserError(fmt::format("{}: the file exists already; name a new folder", to.string()));
  fs::create_directories(folder, error);
  for (const fs::path& file : files)
    if (const fs::path to = folder / file.filename(); !fs::copy_file(file, to, error))
      throw UserError(fmt::format("{}: cannot be written ({})", to.string(), error.message()));
  if (name == "garment") run_silently("voile-manikin", {"manikin", (folder / "body.obj").string(), "--arms", "40"});
  const std::string at = folder.lexically_normal().string();
  fmt::print(
      "{} contains a new case. {}\nNext:\n  voile check {}/case.toml\n  voile run {}/case.toml --output {}/run\n"
      "  voile render {}/run{}{} --output {}/picture.png\n",
      at, chosen->what, at, at, at, at, *chosen->picture ? " " : "", chosen->picture, at);
}

}  // namespace voile::app

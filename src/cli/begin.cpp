#include "begin.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

#include "base/plain_file.hpp"
#include "base/shipped_files.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

namespace {

namespace fs = std::filesystem;

/// Files of a template, by name. Throws UserError if there are none.
std::map<std::string, std::string> texts_of(const fs::path& from) {
  std::map<std::string, std::string> texts;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(from, ignored))
    if (entry.is_regular_file(ignored))
      texts[entry.path().filename().string()] = text_of_file(entry.path()).value_or("");
  if (texts.empty())
    throw UserError(
        fmt::format("{}: the files of the template are missing; install Voile whole (cmake --install)", from.string()));
  return texts;
}

}  // namespace

void run_silently(const std::string& name, std::vector<std::string> words, const fs::path& folder,
                  const fs::path& log) {
  const std::string program = fs::absolute(program_of_ours(name)).string();
  words.insert(words.begin(), program);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.empty() ? "/dev/null" : log.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (!log.empty()) posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
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
  write_new_files(folder, texts_of(shipped_folder("templates") / name));
  if (name == "garment") run_silently("voile-manikin", {"manikin", (folder / "body.obj").string(), "--arms", "40"});
  print_next(folder, chosen->what, chosen->picture);
}

void write_new_files(const fs::path& folder, const std::map<std::string, std::string>& texts) {
  std::error_code error;
  for (const auto& [name, text] : texts)
    if (const fs::path to = folder / name; fs::exists(fs::symlink_status(to, error)))
      throw UserError(fmt::format("{}: the file exists already; name a new folder", to.string()));
  fs::create_directories(folder, error);
  for (const auto& [name, text] : texts) {
    std::ofstream out(folder / name, std::ios::binary);
    if (!(out << text).flush())
      throw UserError(fmt::format("{}: cannot be written ({})", (folder / name).string(), std::strerror(errno)));
  }
}

void print_next(const fs::path& folder, const std::string& what, const std::string& picture) {
  const std::string at = folder.lexically_normal().string();
  fmt::print(
      "{} contains a new case. {}\nNext:\n  voile check {}/case.toml\n  voile run {}/case.toml --output {}/run\n"
      "  voile render {}/run{}{} --output {}/picture.png\n",
      at, what, at, at, at, at, picture.empty() ? "" : " ", picture, at);
}

}  // namespace voile::cli

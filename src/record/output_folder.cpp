#include "output_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "base/plain_file.hpp"
#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::record {

namespace fs = std::filesystem;

namespace {

constexpr const char* lock_name = "run.lock";
/// What a run leaves behind, besides folders of steps.
constexpr std::array own_files{
    "results.vtkhdf",       "results.xdmf", "obstacles.xdmf", "checkpoint.h5",     "modes.csv",         "response.csv",
    "history.csv",          "seams.csv",    "summary.json",   "intersections.vtk", "intersections.png", "remeshing.csv",
    OutputFolder::echo_name};

/// Folders of results of their own.
constexpr std::array inner_folders{"modes", "response", "random"};

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

/// A folder of one file per step, which goes if nothing else is in it.
void remove_steps(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_symlink(folder, ignored)) return;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    std::string name = entry.path().filename().string();
    if (name.starts_with("epoch_")) name.erase(0, 6);
    if (name == "obstacles.h5") name.insert(0, 1, '0');
    const std::size_t digits = static_cast<std::size_t>(
        std::find_if_not(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c); }) - name.begin());
    if (digits > 0 && (name.substr(digits) == ".h5" || name.substr(digits) == ".h5.part"))
      fs::remove(entry.path(), ignored);
  }
  fs::remove(folder, ignored);  // only if it is empty
}

void remove_results(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_symlink(folder, ignored)) return;
  for (const char* name : own_files)
    for (const char* ending : {"", ".part"}) fs::remove(folder / (std::string(name) + ending), ignored);
  remove_steps(folder / "steps");
  for (const char* name : inner_folders) {
    if (!fs::is_directory(folder / name)) continue;
    remove_results(folder / name);
    fs::remove(folder / name, ignored);  // only if it is empty
  }
}

bool is_own(const std::string& name) {
  const bool part = name.ends_with(".part");
  const std::string whole = part ? name.substr(0, name.size() - 5) : name;
  return contains(own_files, whole) || whole == lock_name || whole == "steps" || contains(inner_folders, whole);
}

/// A folder that somebody else has made must not lead a run out of it. Throws UserError if what a run
/// writes into it is a symbolic link, a pipe or a device, or a file that has another name elsewhere.
void refuse_links(const fs::path& folder) {
  const auto refuse = [](const fs::path& place, const char* what) {
    throw UserError(fmt::format(
        "--output: {} is {}, through which this run could write to another place; remove it, or choose another folder",
        place.string(), what));
  };
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!is_own(name) && folder.filename() != "steps") continue;
    const fs::file_status status = entry.symlink_status(ignored);
    if (fs::is_symlink(status)) refuse(entry.path(), "a symbolic link");
    if (!fs::is_regular_file(status) && !fs::is_directory(status)) refuse(entry.path(), "a pipe, a socket or a device");
    if (fs::is_directory(status)) refuse_links(entry.path());
    if (name == lock_name && entry.hard_link_count(ignored) > 1)
      refuse(entry.path(), "a file that has another name elsewhere");
  }
}

void write_echo(const fs::path& folder, const input::Case& c) {
  std::ofstream echo(folder / OutputFolder::echo_name);
  echo << input::echo_case(c) << std::flush;
  if (!echo) throw UserError(fmt::format("--output {}: the folder cannot be written", folder.string()));
}

}  // namespace

OutputFolder::OutputFolder(const input::Case& c, const RunOptions& options)
    : folder_(options.output), lock_file_(folder_ / lock_name) {
  create();
  refuse_links(folder_);
  for (const input::Case& stage : c.stages) {
    require_no_link(folder_ / stage.stage.name);
    refuse_links(folder_ / stage.stage.name);
  }
  for (const fs::path& input : {c.file, options.restart}) refuse_input(input);
  lock();
  try {
    options.from.empty() ? replace(options.overwrite) : replace_stages(c, options);
    write_echo(folder_, c);
  } catch (...) {
    unlock();
    throw;
  }
}

OutputFolder::~OutputFolder() {
  unlock();
}

void OutputFolder::create() const {
  std::error_code error, ignored;
  fs::create_directories(folder_, error);
  if (!fs::is_directory(folder_, ignored))
    throw UserError(fmt::format("--output {}: the folder cannot be made: {}", folder_.string(),
                                error ? error.message() : "a file has that name"));
}

/// A run may be repeated from its own echo, but not over it.
void OutputFolder::refuse_input(const fs::path& input) const {
  std::error_code ignored;
  const fs::path parent = input.parent_path().empty() ? "." : input.parent_path();
  const std::string name = input.filename().string();
  if (std::find(own_files.begin(), own_files.end(), name) != own_files.end() &&
      fs::equivalent(parent, folder_, ignored))
    throw UserError(fmt::format("--output {}: this run would overwrite its own input {}; choose another folder",
                                folder_.string(), input.string()));
}

/// The system frees the lock when the process ends, however it ends; the file tells who holds it.
void OutputFolder::lock() {
  descriptor_ = open(lock_file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0644);
  if (descriptor_ < 0)
    throw UserError(fmt::format("--output {}: the folder cannot be written: {}", folder_.string(), strerror(errno)));
  // Some network drives know no locks; there the run goes on without.
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(descriptor_);
    descriptor_ = -1;
    throw UserError(fmt::format("--output {}: another run writes into it ({}); wait for it or choose another folder",
                                folder_.string(), holder()));
  }
  struct stat held {
  }, named{};
  if (fstat(descriptor_, &held) == 0 && (stat(lock_file_.c_str(), &named) != 0 || held.st_ino != named.st_ino)) {
    close(descriptor_);  // the run that held it has just ended and taken the file away
    return lock();
  }
  const std::string text = fmt::format("host {}, process {}\n", host_name(), getpid());
  if (ftruncate(descriptor_, 0) != 0 || write(descriptor_, text.data(), text.size()) < 0) {
    const std::string why = strerror(errno);
    unlock();
    throw UserError(fmt::format("--output {}: the folder cannot be written: {}", folder_.string(), why));
  }
}

void OutputFolder::unlock() {
  if (descriptor_ < 0) return;
  std::error_code ignored;
  fs::remove(lock_file_, ignored);
  close(descriptor_);
  descriptor_ = -1;
}

std::string OutputFolder::holder() const {
  std::ifstream in(lock_file_);
  std::string line;
  std::getline(in, line);
  return line.empty() ? "it has just begun" : line;
}

void OutputFolder::replace(bool allowed) const {
  std::string first;
  for (const auto& entry : fs::directory_iterator(folder_))
    if (entry.path().filename() != lock_name) first = std::max(first, entry.path().filename().string());
  if (first.empty()) return;
  if (!fs::exists(folder_ / echo_name))
    throw UserError(
        fmt::format("--output {}: the folder is not empty ('{}' ...) and holds no run of this program; choose a new or "
                    "empty folder",
                    folder_.string(), first));
  if (!allowed)
    throw UserError(fmt::format(
        "--output {}: the folder holds an earlier run; choose another one, or give --overwrite to replace it",
        folder_.string()));
  remove_results(folder_);
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    if (entry.is_symlink(ignored) || !fs::exists(entry.path() / echo_name, ignored)) continue;  // not a stage
    remove_results(entry.path());
    fs::remove(entry.path(), ignored);
  }
}

/// From the stage on that a run begins with.
void OutputFolder::replace_stages(const input::Case& c, const RunOptions& options) const {
  bool begun = false;
  for (const input::Case& stage : c.stages) {
    begun = begun || stage.stage.name == options.from;
    const fs::path of_stage = folder_ / stage.stage.name;
    std::error_code ignored;
    if (!begun || !fs::exists(of_stage, ignored)) continue;
    if (!options.restart.empty() && fs::equivalent(options.restart.parent_path(), of_stage, ignored))
      throw UserError(fmt::format("--restart {}: this run would overwrite its own input; choose another --output",
                                  options.restart.string()));
    if (!options.overwrite)
      throw UserError(
          fmt::format("--output {}: the folder holds stage '{}' of an earlier run; give --overwrite to "
                      "replace it and what came after",
                      folder_.string(), stage.stage.name));
    remove_results(of_stage);
  }
}

void OutputFolder::add(const input::Case& stage) const {
  const fs::path of_stage = folder_ / stage.stage.name;
  std::error_code ignored;
  fs::create_directories(of_stage, ignored);
  write_echo(of_stage, stage);
}

}  // namespace voile::record

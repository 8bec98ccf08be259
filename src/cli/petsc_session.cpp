#include "petsc_session.hpp"

#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "input/command_line.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

namespace {

bool is_root() {
  return mpi::rank(MPI_COMM_WORLD) == 0;
}

}  // namespace

PetscSession::PetscSession(const char* program, const std::vector<std::string>& words,
                           const std::string& case_options) {
  for (const auto& [name, value] : input::petsc_pairs(case_options))
    VOILE_PETSC(PetscOptionsSetValue(nullptr, name.c_str(), value.empty() ? nullptr : value.c_str()));
  // PETSc would end the program silently.
  for (std::size_t i = 0; i + 1 < words.size(); ++i)
    if (words[i] == "-options_file" && !std::ifstream(words[i + 1]))
      throw UserError(fmt::format("-options_file {}: it cannot be read", words[i + 1]));
  words_.emplace_back(program);
  if (std::find(words.begin(), words.end(), "-skip_petscrc") == words.end()) words_.emplace_back("-skip_petscrc");
  words_.insert(words_.end(), words.begin(), words.end());
  for (std::string& word : words_) pointers_.push_back(word.data());
  pointers_.push_back(nullptr);
  count_ = static_cast<int>(words_.size());
  argv_ = pointers_.data();
  VOILE_PETSC(PetscInitialize(&count_, &argv_, nullptr, nullptr));
  // `voile ... | head` ends as other programs do: PETSc would tell of a crash.
  (void)std::signal(SIGPIPE, SIG_DFL);
  petsc::collect_errors();
  slepc_.emplace();
}

PetscSession::~PetscSession() {
  slepc_.reset();
  try {
    VOILE_PETSC(PetscFinalize());  // the last options are looked up here
  } catch (const std::exception& e) {
    if (is_root()) fmt::print(stderr, "voile: error: {}\n", e.what());
  }
}

void PetscSession::check_tolerances() {
  char* all = nullptr;
  VOILE_PETSC(PetscOptionsGetAll(nullptr, &all));
  std::istringstream words(all);
  VOILE_PETSC(PetscFree(all));
  std::string name;
  for (std::string word; words >> word; name = word) {
    const bool is_limit = name.ends_with("tol") || name.ends_with("_max_it") || name.ends_with("_max_steps") ||
                          name.ends_with("_dt") || name.ends_with("_max_time");
    if (!is_limit || name.find("divergence") != name.npos) continue;
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (end != word.c_str() && *end == '\0' && !(value >= 0.0))
      throw UserError(fmt::format("{} {}: it must not be negative; give a number of 0 or more", name, word));
  }
}

void PetscSession::report_unused_options() {
  PetscBool asked = PETSC_FALSE;
  VOILE_PETSC(PetscOptionsHasName(nullptr, nullptr, "-options_left", &asked));
  if (asked) return;
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  VOILE_PETSC(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  for (PetscInt i = 0; i < count && is_root(); ++i) {
    const std::string name = names[i];
    // These are looked up only when PETSc ends.
    const bool late = name.starts_with("log") || name.starts_with("malloc") || name.starts_with("objects_") ||
                      name.starts_with("options_");
    if (!late)
      fmt::print(stderr, "voile: warning: option -{}{}{} was not used by anything\n", name, values[i] ? " " : "",
                 values[i] ? values[i] : "");
  }
  VOILE_PETSC(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
}

}  // namespace voile::cli

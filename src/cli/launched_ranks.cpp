#include "launched_ranks.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>

namespace voile::cli {

namespace {

struct Launcher {
  const char *rank, *size, *job;
};
// Slurm sets its number of tasks for a program that runs alone, too: of its ranks only the first differs.
constexpr std::array launchers{Launcher{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "PMIX_NAMESPACE"},
                               Launcher{"PMI_RANK", "PMI_SIZE", "PMI_JOBID"}, Launcher{"PMIX_RANK", "", ""},
                               Launcher{"SLURM_PROCID", "", ""}};

std::optional<int> number_of(const char* name) {
  const char* text = *name == '\0' ? nullptr : std::getenv(name);
  return text ? std::optional(std::atoi(text)) : std::nullopt;
}

}  // namespace

LaunchedRank launched_rank() {
  for (const Launcher& launcher : launchers) {
    const std::optional<int> rank = number_of(launcher.rank);
    if (!rank) continue;
    LaunchedRank own;
    own.rank = *rank;
    const char* job = *launcher.job == '\0' ? nullptr : std::getenv(launcher.job);
    const int size = number_of(launcher.size).value_or(1);
    if (job == nullptr || *job == '\0' || *rank < 0 || *rank >= size) return own;
    own.size = size;
    own.job = job;
    return own;
  }
  return {};
}

bool is_launched() {
  return std::any_of(launchers.begin(), launchers.end(), [](const Launcher& l) { return number_of(l.rank); });
}

}  // namespace voile::cli

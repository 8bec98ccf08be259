#include "delegate.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "voile/base/error.hpp"

namespace voile::app {

namespace {

/// What starts ranks tells each which it is.
bool is_first_rank() {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"})
    if (const char* rank = std::getenv(name)) return std::string(rank) == "0";
  return true;
}

}  // namespace

void delegate_pictures(int argc, char** argv) {
  if (argc < 2 || std::none_of(picture_commands.begin(), picture_commands.end(),
                               [&](const auto& c) { return std::string(argv[1]) == c.first; }))
    return;
  if (!is_first_rank()) std::exit(0);
  std::error_code error;
  const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "voile-picture";
  (void)execv(program.c_str(), argv);
  throw UserError(
      fmt::format("{}: the program that draws and exports cannot be started; install it beside voile, or build it "
                  "(target voile-picture)",
                  program.string()));
}

}  // namespace voile::app

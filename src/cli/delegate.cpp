#include "delegate.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "launched_ranks.hpp"
#include "voile/errors.hpp"

namespace voile::cli {

void delegate_command(int argc, char** argv) {
  if (argc < 2) return;
  const auto command = std::find_if(delegated_commands.begin(), delegated_commands.end(),
                                    [&](const DelegatedCommand& c) { return std::string(argv[1]) == c.name; });
  if (command == delegated_commands.end()) return;
  if (launched_rank().rank != 0 && !command->on_all_ranks) std::exit(0);
  std::error_code error;
  const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / command->program;
  (void)execv(program.c_str(), argv);
  throw UserError(
      fmt::format("{}: the program of the command {} cannot be started; install it beside voile, or build "
                  "it (target {})",
                  program.string(), command->name, command->program));
}

}  // namespace voile::cli

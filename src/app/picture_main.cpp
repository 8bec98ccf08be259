// voile-picture render | export | plot | view: what `voile` does with these commands.
//
// A program of its own, which starts without the solver's libraries.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <new>

#include "picture_commands.hpp"
#include "voile/base/error.hpp"

namespace {

using namespace voile;

int run(int argc, char** argv) {
  CLI::App cli("Pictures, animations and exchange of results", "voile");
  cli.require_subcommand(1);
  app::RenderCommand render(cli);
  app::ExportCommand exporting(cli);
  app::PlotCommand plot(cli);
  app::ViewCommand view(cli);
  std::vector<std::string> words(argv + 1, argv + argc);
  std::reverse(words.begin(), words.end());
  try {
    cli.parse(words);
  } catch (const CLI::CallForHelp&) {
    const auto chosen = cli.get_subcommands();
    fmt::print("{}", chosen.empty() ? cli.help() : chosen.front()->help("voile"));
    return 0;
  } catch (const CLI::ParseError& e) {
    throw UserError(fmt::format("{}; see voile {} --help", e.what(), argc > 1 ? argv[1] : ""));
  }
  if (render.chosen()) render.run();
  if (exporting.chosen()) exporting.run();
  if (plot.chosen()) plot.run();
  if (view.chosen()) view.run();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const UserError& e) {
    fmt::print(stderr, "voile: error: {}\n", e.what());
    return static_cast<int>(Exit::user_error);
  } catch (const std::bad_alloc&) {
    fmt::print(
        stderr,
        "voile: error: out of memory: the picture or the mesh is too large for this machine; make --size smaller\n");
    return static_cast<int>(Exit::user_error);
  } catch (const std::exception& e) {
    fmt::print(stderr, "voile: internal error: {}\n", e.what());
    return static_cast<int>(Exit::internal_error);
  }
}

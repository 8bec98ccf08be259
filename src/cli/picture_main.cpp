// voile-picture render | export | plot | sheet | view: what `voile` does with these commands.
// voile-picture tangle MESSAGE PICTURE: for src/setup/obstacles.cpp, of triangles that intersect.
//
// A program of its own, which starts without the solver's libraries.
#include <memory>
#include <string>

#include "base/child_process.hpp"
#include "base/terminal.hpp"
#include "command_program.hpp"
#include "picture_commands.hpp"
#include "picture_plot.hpp"
#include "picture_tangle.hpp"
#include "results/stored_run.hpp"

namespace {

using namespace voile;

struct Commands {
  explicit Commands(CLI::App& cli) : render(cli), exporting(cli), plot(cli), sheet(cli), view(cli) {}
  void act() {
    if (render.chosen()) render.run();
    if (exporting.chosen()) exporting.run();
    if (plot.chosen()) plot.run();
    if (sheet.chosen()) sheet.run();
    if (view.chosen()) view.run();
  }

  cli::RenderCommand render;
  cli::ExportCommand exporting;
  cli::PlotCommand plot;
  cli::SheetCommand sheet;
  cli::ViewCommand view;
};

}  // namespace

int main(int argc, char** argv) {
  keep_output_streams();
  if (cli::is_launched()) use_plain_output(false);
  if (argc == 4 && std::string(argv[1]) == "tangle")
    return answer_to_parent([&] { return cli::draw_tangle(argv[2], argv[3]); });
  results::leave_hdf5_at_exit();
  return cli::command_program(
      argc, argv, "Pictures, animations and exchange of results",
      "the picture or the mesh is too large for this machine; make --size smaller, or take fewer --steps",
      [](CLI::App& cli) {
        auto commands = std::make_shared<Commands>(cli);
        return [commands] { commands->act(); };
      });
}

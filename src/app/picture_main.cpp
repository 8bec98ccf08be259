// voile-picture render | export | plot | view: what `voile` does with these commands.
//
// A program of its own, which starts without the solver's libraries.
#include <memory>

#include "command_program.hpp"
#include "picture_commands.hpp"

namespace {

using namespace voile;

struct Commands {
  explicit Commands(CLI::App& cli) : render(cli), exporting(cli), plot(cli), view(cli) {}
  void act() {
    if (render.chosen()) render.run();
    if (exporting.chosen()) exporting.run();
    if (plot.chosen()) plot.run();
    if (view.chosen()) view.run();
  }

  app::RenderCommand render;
  app::ExportCommand exporting;
  app::PlotCommand plot;
  app::ViewCommand view;
};

}  // namespace

int main(int argc, char** argv) {
  return app::command_program(
      argc, argv, "Pictures, animations and exchange of results",
      "the picture or the mesh is too large for this machine; make --size smaller, or take fewer --steps",
      [](CLI::App& cli) {
        auto commands = std::make_shared<Commands>(cli);
        return [commands] { commands->act(); };
      });
}

#include "stages.hpp"

#include <algorithm>

#include "model_input.hpp"
#include "voile/solve/load_path.hpp"
#include "voile/solve/time_integration.hpp"

namespace voile::app {

namespace {

/// What PETSc's options have to say wins over the case file.
void take_options(input::Case& c) {
  solve::read_path_options(PETSC_COMM_WORLD, c.steps);
  if (c.analysis == "modal" || c.analysis == "buckling") {
    c.steps.final_load_factor = c.eigen.load_factor;
    std::erase_if(c.steps.stops, [&](double stop) { return stop > c.eigen.load_factor; });
  }
  if (c.analysis == "dynamic") solve::read_time_options(c.time.options);
}

}  // namespace

std::vector<Stage> stages_of(const input::Case& c, const RunOptions& options) {
  std::vector<Stage> stages;
  KnownObstacles known;
  const auto add = [&](const input::Case& one, const std::filesystem::path& folder) {
    Stage s{one, options, {}};
    s.options.output = folder;
    take_options(s.c);
    s.input = model_input(s.c, known);
    stages.push_back(std::move(s));
  };
  if (c.stages.empty()) add(c, options.output);
  for (const input::Case& one : c.stages) add(one, options.output / one.stage);
  return stages;
}

}  // namespace voile::app

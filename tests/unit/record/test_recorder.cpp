// What a run records of its states.
#include <doctest/doctest.h>

#include <fstream>
#include <sstream>

#include "base/mpi.hpp"
#include "record/recorder.hpp"
#include "test_case_kit.hpp"
#include "test_model_kit.hpp"

namespace voile::test_recorder {

TEST_CASE("a state that intersects is counted and recorded, and ends the run") {
  const mesh::SurfaceMesh mesh(testing::square(testing::Pattern::union_jack, 4));
  system::ModelInput input;
  input.materials = {testing::isotropic(1e6, 0.3, 1e-3, 1.0)};
  input.contact.active = true;
  input.contact.options.distance = 1e-3;
  contact::Obstacle ball;
  ball.name = "ball";
  ball.shape = contact::Obstacle::Shape::sphere;
  ball.points = {{0.5, 0.5, 1.0}};
  ball.radius = 0.3;
  input.contact.obstacles = {ball};
  system::Model model(PETSC_COMM_WORLD, mesh, input);
  input::Case c;
  c.analysis = input::Analysis::statics;
  c.contact.input = input.contact;
  record::RunOptions options;
  options.verbosity = record::Verbosity::quiet;
  options.output = std::filesystem::temp_directory_path() / "voile_test_recorder";
  mpi::on_root(PETSC_COMM_WORLD, [&] {
    std::filesystem::remove_all(options.output);
    std::filesystem::create_directories(options.output);
  });
  {
    record::Recorder recorder(c, options, model);
    recorder.use(model, nullptr);
    system::State state = system::state_at_rest(model.dofs());
    solve::StepResult result;
    CHECK_NOTHROW(recorder.record(state, result, true));
    state.step = 1;
    testing::set_displacement(model, state.u, [](Index) { return Vec3(0.0, 0.0, 1.0); });
    CHECK_THROWS_AS(recorder.record(state, result, false), InternalError);
    recorder.finish();
  }
  mpi::on_root(PETSC_COMM_WORLD, [&] {
    std::ifstream file(options.output / "history.csv");
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    REQUIRE(lines.size() == 3);
    const auto split = [](const std::string& line) {
      std::vector<std::string> parts;
      std::stringstream stream(line);
      for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
      return parts;
    };
    const std::vector<std::string> names = split(lines[0]);
    const auto at = static_cast<std::size_t>(std::find(names.begin(), names.end(), "intersections") - names.begin());
    REQUIRE(at < names.size());
    CHECK(std::stod(split(lines[1])[at]) == 0.0);
    CHECK(std::stod(split(lines[2])[at]) >= 8.0);
    CHECK(std::filesystem::exists(options.output / "intersections.vtk"));
    std::filesystem::remove_all(options.output);
  });
}

}  // namespace voile::test_recorder

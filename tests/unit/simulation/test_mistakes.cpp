// What the library does with mistakes, with options and with files.
#include <filesystem>

#include "test_strip.hpp"

namespace voile::test_mistakes {

using namespace testing;

TEST_CASE("mistakes are thrown on every rank, and the process can go on") {
  Case wrong = strip("dynamic");
  wrong.set("support.0.group", "clomp");
  CHECK_THROWS_AS(Simulation(PETSC_COMM_WORLD, wrong), UserError);
  Case missing = strip("dynamic");
  missing.set("mesh.file", "/nowhere.msh");
  CHECK_THROWS_AS(Simulation(PETSC_COMM_WORLD, missing), UserError);
  CHECK_THROWS_AS(Simulation(PETSC_COMM_WORLD, strip("dynamic"), {.petsc = "-ts_type beuler"}), UserError);
  Case apart = strip("dynamic");
  Simulation s(PETSC_COMM_WORLD, apart), other(PETSC_COMM_WORLD, apart);
  const State saved = other.save();
  CHECK_THROWS_AS(s.restore(saved), UserError);
  CHECK_THROWS_AS(s.restore(State()), UserError);
  CHECK(s.run());
}

TEST_CASE("PETSc's options are those of one simulation") {
  Case c = strip("dynamic");
  Simulation short_one(PETSC_COMM_WORLD, c, {.petsc = "-ts_max_time 0.04"}), whole(PETSC_COMM_WORLD, c);
  CHECK(short_one.run());
  CHECK(whole.run());
  CHECK(short_one.time() == 0.04);
  CHECK(whole.time() == 0.1);
  PetscBool left = PETSC_FALSE;
  PetscOptionsHasName(nullptr, nullptr, "-ts_max_time", &left);
  CHECK(left == PETSC_FALSE);
}

TEST_CASE("a simulation that does not converge says so, and is gone back on") {
  Case c = strip("static");
  c.set("load.0.vector", {0, 0, 1e3}).set("steps.max_steps", 1).set("steps.initial_step", 1e-4);
  Simulation s(PETSC_COMM_WORLD, c);
  const State start = s.save();
  CHECK(!s.run());
  CHECK(s.finished());
  CHECK(!s.converged());
  CHECK(s.reason().find("max_steps") != std::string::npos);
  s.restore(start);
  CHECK(!s.finished());
  CHECK(s.advance().accepted);
}

TEST_CASE("files are written where a folder is named, and nowhere else") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "voile_test_simulation";
  mpi::on_root(PETSC_COMM_WORLD, [&] { std::filesystem::remove_all(folder); });
  {
    Simulation s(PETSC_COMM_WORLD, strip("dynamic"), {.output = folder});
    const State saved = s.save();
    CHECK(s.run());
    CHECK_THROWS_AS(s.restore(saved), UserError);
  }
  mpi::on_root(PETSC_COMM_WORLD, [&] {
    for (const char* name : {"results.vtkhdf", "history.csv", "summary.json", "checkpoint.h5", "resolved_case.toml"})
      CHECK(std::filesystem::exists(folder / name));
  });
  CHECK_THROWS_AS(Simulation(PETSC_COMM_WORLD, strip("dynamic"), {.output = folder}), UserError);
  mpi::on_root(PETSC_COMM_WORLD, [&] { std::filesystem::remove_all(folder); });
  const std::filesystem::path before = std::filesystem::current_path();
  mpi::on_root(PETSC_COMM_WORLD, [&] {
    std::filesystem::create_directories(folder);
    std::filesystem::current_path(folder);
  });
  for (const char* analysis : {"linear", "static", "dynamic", "drape", "modal", "buckling"}) {
    Case c = strip(analysis);
    if (analysis == std::string("buckling")) c.set("load.0.vector", {-0.4, 0, 0});
    Simulation s(PETSC_COMM_WORLD, c);
    CHECK(s.run());
  }
  mpi::on_root(PETSC_COMM_WORLD, [&] {
    CHECK(std::filesystem::is_empty(folder));
    std::filesystem::current_path(before);
    std::filesystem::remove_all(folder);
  });
}

TEST_CASE("what ends in an unstable equilibrium has not converged, as the program ends with code 5") {
  Case straight = strip("static");
  for (const double force : {-1.0, -3.0}) {  // pi^2 D/4 = 2.06 N/m is Euler's
    straight.set("load.0.vector", {force, 0, 0});
    Simulation at_once(PETSC_COMM_WORLD, straight), by_steps(PETSC_COMM_WORLD, straight);
    const bool stable = force > -2.0;
    CHECK(at_once.run() == stable);
    CHECK(at_once.reason().empty() == stable);
    CHECK(!by_steps.converged());
    while (!by_steps.finished()) CHECK(by_steps.advance().accepted);
    CHECK(by_steps.converged() == stable);
    CHECK(by_steps.reason() == at_once.reason());
  }
}

}  // namespace voile::test_mistakes

// A stage on the shape that modes of an earlier one have made imperfect, without files.
#include "setup/imperfections.hpp"
#include "test_strip.hpp"

namespace voile::test_imperfect_stages {

using namespace testing;

namespace {

Case buckled() {
  Case c = strip("static");
  const std::string text = c.source();
  return Case::parse(text.substr(text.find("mesh =")) + R"(
[[imperfection]]
type = "modes"
stage = "buckle"
modes = [1]
amplitudes = [1e-3]
[[stage]]
name = "buckle"
analysis = "buckling"
eigen = { modes = 1 }
[[stage]]
name = "path"
analysis = "static"
)")
      .set("load.0.vector", {-1e-2, 0, 0});
}

}  // namespace

TEST_CASE("a stage begins anew on the shape with the modes of the one before, also without files") {
  Simulation whole(PETSC_COMM_WORLD, buckled());
  CHECK(whole.load_factor() == 0.0);
  CHECK(std::abs(tip_height(whole)) == doctest::Approx(1e-3).epsilon(1e-3));  // the amplitude
  CHECK(whole.run());
  CHECK(whole.converged());
  CHECK(std::abs(tip_height(whole)) > 1e-3);  // it bends further the way it is bent
  CHECK(std::abs(tip_height(whole)) < 2e-3);
  Simulation alone(PETSC_COMM_SELF, buckled());
  CHECK(alone.run());
  CHECK(std::abs(std::abs(tip_height(whole)) - std::abs(tip_height(alone))) < 1e-9);
}

}  // namespace voile::test_imperfect_stages

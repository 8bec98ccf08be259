// Stages: what of a case each is, and supports that take hold of what they find.
#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "input/case.hpp"
#include "test_model_kit.hpp"
#include "test_relative.hpp"
#include "test_text.hpp"
#include "voile/errors.hpp"

namespace test_stages {

using namespace voile;
using namespace voile::testing;
using Kind = system::Support::Kind;

namespace {

constexpr const char* staged = R"(title = "staged"
[mesh]
file = "sheet.msh"
[[material]]
type = "isotropic"
young = 1e6
poisson = 0.3
thickness = 1e-3
density = 500
[[support]]
group = "left"
type = "clamped"
[[support]]
group = "right"
type = "hinged"
motion = ["t", "0", "0"]
stages = ["pull", "rest"]
[[load]]
type = "gravity"
vector = [0, 0, -9.81]
[[load]]
type = "point"
group = "tip"
vector = [0, 0, 1]
stages = ["rest"]
[[obstacle]]
name = "ball"
type = "sphere"
point = [0, 0, -1]
radius = 0.5
motion = ["0", "0", "t"]
[time]
step = 0.25
end = 1
[[stage]]
name = "drape"
analysis = "drape"
[[stage]]
name = "pull"
analysis = "dynamic"
[stage.time]
end = 3
[[stage]]
name = "rest"
analysis = "modal"
[stage.eigen]
modes = 9
)";

std::string error_of(const std::string& text, const std::vector<std::string>& settings = {}) {
  try {
    (void)input::parse_case(text, "dir/case.toml", settings);
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

std::string with(const std::string& what, const std::string& instead) {
  std::string text = staged;
  text.replace(text.find(what), what.size(), instead);
  return text;
}

}  // namespace

TEST_CASE("each stage is a case with its own tables, without what does not hold in it") {
  const input::Case c = input::parse_case(staged, "dir/case.toml", {"stage.2.eigen.modes=11"});
  CHECK_FALSE(c.is_staged());
  REQUIRE(c.stages.size() == 3);
  const input::Case &drape = c.stages[0], &pull = c.stages[1], &rest = c.stages[2];
  CHECK(drape.stage.name == "drape");
  CHECK(pull.stage.number == 1);
  CHECK(rest.analysis == input::Analysis::modal);
  CHECK(drape.supports.size() == 1);
  CHECK(pull.stage.supports == std::vector<std::size_t>{0, 1});
  CHECK(pull.supports[1].motion);
  CHECK(pull.loads.size() == 1);
  CHECK(rest.stage.loads == std::vector<std::size_t>{0, 1});
  // Its own table lies over that of the case, key by key.
  CHECK(drape.time.options.end_time == 1.0);
  CHECK(pull.time.options.end_time == 3.0);
  CHECK(pull.time.options.step == 0.25);
  CHECK(rest.eigen.modes == 11);
  // What knows no contact has none.
  CHECK(drape.contact.input.active);
  CHECK(pull.obstacles.size() == 1);
  CHECK_FALSE(rest.contact.input.active);
  CHECK(rest.obstacles.empty());
  // The echo says the same again.
  const input::Case again = input::parse_case(input::echo_case(c), "elsewhere/case.toml");
  REQUIRE(again.stages.size() == 3);
  CHECK(again.stages[1].supports.size() == 2);
  CHECK(again.stages[2].eigen.modes == 11);
  CHECK(again.mesh.file == c.mesh.file);
}

TEST_CASE("a stage that sews loses what a seam brings to a stop, as contact does") {
  const std::string sewn = R"([[panel]]
file = "a.svg"
size = 0.01
[[seam]]
name = "side"
edges = ["a/0"]
to = ["a/2"]
[[material]]
type = "isotropic"
young = 1e6
poisson = 0.3
thickness = 1e-3
density = 400
[[stage]]
name = "sew"
analysis = "dynamic"
sew = ["all"]
[stage.time]
end = 1
[[stage]]
name = "swing"
analysis = "dynamic"
[stage.time]
end = 2
)";
  const input::Case c = input::parse_case(sewn, "dir/case.toml");
  CHECK(c.stages.at(0).time.options.radius == 0.0);
  CHECK(c.stages.at(1).time.options.radius == 0.5);
  CHECK(
      input::parse_case(sewn, "dir/case.toml", {"stage.0.time.spectral_radius=0.5"}).stages.at(0).time.options.radius ==
      0.5);
}

TEST_CASE("mistakes in stages name file, line and remedy") {
  CHECK(has(error_of(with("stages = [\"rest\"]", "stages = [\"ret\"]")),
            "dir/case.toml:25: load.stages: there is no stage 'ret'"));
  CHECK(has(error_of(with("name = \"pull\"", "name = \"drape\"")), "another stage has it"));
  CHECK(has(error_of(with("end = 3", "edn = 3")), "unknown key 'edn'"));
  CHECK(has(error_of(with("end = 3", "end = -3")), "dir/case.toml:42: time.end"));
  CHECK(has(error_of(with("[stage.eigen]", "[stage.eign]")), "unknown key or table 'eign'"));
  CHECK(has(error_of(with("title = \"staged\"", "analysis = \"drape\"")), "each [[stage]] has its own"));
  CHECK(has(error_of(with("analysis = \"modal\"", "analysis = \"linear\"")), "make it the first stage"));
  CHECK(has(error_of(with("name = \"pull\"", "name = \"a/b\"")), "name of a folder"));
  CHECK(has(error_of(staged, {"stage.3.name=x"}), "not the number of one of its 3 sections"));
}

TEST_CASE("supports take hold of what they find: value, motion and rotation count from there") {
  mesh::MeshData d = grid(6, 3, true, 0.2, 3);
  add_square_groups(d);
  const mesh::SurfaceMesh mesh(d);
  system::ModelInput in;
  in.materials = {isotropic(1e5, 0.3, 0.01)};
  in.supports = {support("left", Kind::hinged), support("right", Kind::displacement)};
  const Vec3 centre(0.3, -0.2, 0.1);
  const auto turn = [](double t) { return Mat3(Eigen::AngleAxisd(t, Vec3(1.0, 2.0, -1.0).normalized())); };
  const auto way = [](double t) { return Vec3(t * t, 0.2 * t, -t); };
  in.supports[0].motion = [&](const Vec3& x, double t) { return Vec3(turn(t) * (x - centre) - (x - centre) + way(t)); };
  in.supports[1].components = {true, false, true};
  in.supports[1].x_axis = Vec3(1.0, 1.0, 0.5);
  in.supports[1].value = Vec3(0.1, 0.0, -0.2);
  system::Model model(PETSC_COMM_WORLD, mesh, in);
  petsc::VecHandle a = model.dofs().create_vector(), b = model.dofs().create_vector(), r = model.dofs().create_vector();
  const auto found = [&](Index v) { return Vec3(std::sin(7.0 * v), 0.1 * v, std::cos(3.0 * v)); };
  set_displacement(model, a, found);
  const double t0 = 0.7, t1 = 1.9, factor0 = 0.25, factor1 = 1.5;
  model.conditions().take_hold(a, t0, factor0);
  model.set_time(t0);
  model.conditions().set_load_factor(factor0);
  VOILE_PETSC(VecCopy(a, b));
  model.conditions().enforce(b);
  VOILE_PETSC(VecAXPY(b, -1.0, a));
  CHECK(norm(b) < 1e-14);  // nothing jumps
  model.set_time(t1);
  model.conditions().set_load_factor(factor1);
  VOILE_PETSC(VecCopy(a, b));
  model.conditions().enforce(b);
  const std::vector<Vec3> u = per_vertex(model, b);
  for (const Index v : mesh.group("left").vertices) {
    const Vec3 x = mesh.positions()[v];
    const Vec3 wanted = turn(t1) * turn(t0).transpose() * (x + found(v) - centre - way(t0)) + centre + way(t1) - x;
    CHECK((u[v] - wanted).norm() < 1e-13);
  }
  const Vec3 x_axis = Vec3(1.0, 1.0, 0.5).normalized();
  for (const Index v : mesh.group("right").vertices) {
    const Vec3 change = u[v] - found(v);
    CHECK(change.dot(x_axis) == relative((factor1 - factor0) * 0.1).epsilon(1e-12));
    CHECK(change.norm() == relative((factor1 - factor0) * std::hypot(0.1, 0.2)).epsilon(1e-12));
  }
  model.residual(b, r);
  model.dofs().clear_free(r);
  CHECK(norm(r) < 1e-14);
}

}  // namespace test_stages

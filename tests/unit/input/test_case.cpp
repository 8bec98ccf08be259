// The case file: what is read, every kind of mistake with its message, the command line.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "base/text.hpp"
#include "input/case.hpp"
#include "input/command_line.hpp"
#include "test_case_kit.hpp"
#include "test_case_texts.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_case {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::cases;
using input::parse_case;

namespace {

/// The error after `line` is added below the minimal case.
std::string error_with(const std::string& lines) {
  return error_of(minimal + lines);
}

/// The error after a piece of the full case is replaced.
std::string error_after(const std::string& from, const std::string& to) {
  return error_of(replaced(full, from, to));
}

}  // namespace

TEST_CASE("a minimal case has the defaults") {
  const input::Case c = parse_case(minimal, "folder/case.toml");
  CHECK(c.analysis == input::Analysis::statics);
  CHECK(c.mesh.file == std::filesystem::absolute("folder/plate.geo"));
  CHECK(c.mesh.options.scale == 1.0);
  CHECK(c.element.bending == energy::BendingOperator::edge_slope);
  CHECK(c.element.crease_angle == relative(40.0 * std::numbers::pi / 180.0));
  REQUIRE(c.materials.size() == 1);
  CHECK(c.materials[0].groups.empty());
  CHECK(c.materials[0].membrane == energy::isotropic_membrane(2.1e11, 0.3, 0.01));
  CHECK(c.materials[0].bending == energy::bending_from_membrane(c.materials[0].membrane, 0.01));
  CHECK(c.materials[0].areal_density == 0.0);
  CHECK(c.steps.initial_step == 0.25);
  CHECK(c.output.every == 1);
  CHECK(c.output.fields.empty());
  CHECK(c.petsc_options.empty());
}

TEST_CASE("every key is read") {
  const input::Case c = parse_case(full, "/cases/case.toml");
  CHECK(c.title == "All \"keys\"");
  CHECK(c.mesh.file == "/cases/meshes/plate.geo");
  CHECK(c.mesh.options.scale == 0.001);
  CHECK(c.mesh.options.size == 2.5);
  CHECK(c.mesh.options.algorithm == 5);
  CHECK(c.mesh.options.parameters == std::map<std::string, double>{{"L", 2.5}, {"n", 12.0}});
  CHECK(c.element.bending == energy::BendingOperator::six_node);
  CHECK(c.element.membrane == energy::MembraneOperator::cst);
  CHECK(c.element.cst_fraction == 0.3);
  CHECK(c.element.max_patch_condition == 50.0);
  CHECK(c.element.crease_angle == relative(33.3 * std::numbers::pi / 180).epsilon(1e-15));
  REQUIRE(c.materials.size() == 3);
  CHECK(c.materials[0].groups == std::vector<std::string>{"plate", "rim"});
  CHECK(c.materials[0].areal_density == relative(100.0));
  CHECK(c.materials[1].membrane == energy::orthotropic_membrane(3e6, 1e6, 0.2, 4e5, 0.2));
  CHECK(*c.materials[1].direction == Vec3(1, 1, 0));
  CHECK(c.materials[2].membrane(0, 2) == 0.1);
  CHECK(c.materials[2].areal_density == 0.2);
  REQUIRE(c.supports.size() == 4);
  CHECK(c.supports[0].components == std::array<bool, 3>{true, false, true});
  CHECK(c.supports[0].value == Vec3(0.1, 0, -0.2));
  CHECK(c.supports[1].kind == system::Support::Kind::clamped);
  CHECK(*c.supports[2].normal == Vec3(0, 1, 0));
  CHECK(!c.supports[3].normal);
  REQUIRE(c.loads.size() == 3);
  CHECK(c.loads[0].kind == system::Load::Kind::line);
  CHECK(c.loads[0].vector == Vec3(0, 0, -4));
  CHECK(c.loads[1].constant);
  CHECK(c.loads[1].group.empty());
  CHECK(c.loads[2].kind == system::Load::Kind::follower_pressure);
  CHECK(c.loads[2].magnitude == -100.0);
  CHECK(c.steps.stops == std::vector<double>{0.1, 0.7, 2.0});
  CHECK(c.steps.target_iterations == 5);
  CHECK(!c.steps.fallback);
  REQUIRE(c.probes.size() == 3);
  CHECK(*c.probes[0].point == Vec3::Zero());
  CHECK(c.probes[0].components == std::vector<int>{2});
  CHECK(c.probes[1].group == "left");
  CHECK(c.probes[2].kind == input::Probe::Kind::energy);
  CHECK(c.output.fields == std::vector<std::string>{"reaction", "displacement"});
  CHECK(c.output.every == 3);
  CHECK(c.petsc_options == "-snes_rtol 1e-10 -ksp_view");
}

TEST_CASE("each load type is the enumerator of its name") {
  using Kind = system::Load::Kind;
  const std::vector<std::pair<std::string, Kind>> kinds{{"point", Kind::point},
                                                        {"line", Kind::line},
                                                        {"pressure", Kind::pressure},
                                                        {"follower_pressure", Kind::follower_pressure},
                                                        {"area", Kind::area},
                                                        {"gravity", Kind::gravity},
                                                        {"follower_moment", Kind::follower_moment}};
  for (const auto& entry : kinds) {
    const std::string& name = entry.first;
    const Kind kind = entry.second;
    CAPTURE(name);
    const bool vector = kind == Kind::point || kind == Kind::line || kind == Kind::area || kind == Kind::gravity;
    const input::Case c = parse_case(minimal + "[[load]]\ngroup = \"g\"\ntype = \"" + name + "\"\n" +
                                         (vector ? "vector = [1, 2, 3]\n" : "magnitude = 5\n"),
                                     "case.toml");
    CHECK(c.loads.at(0).kind == kind);
  }
}

TEST_CASE("a section that the analysis does not look at is noted, unless it says nothing new") {
  const auto notes = [](const std::string& text) { return parse_case(text, "case.toml").notes; };
  CHECK(notes(minimal).empty());
  CHECK(notes(minimal + "[time]\nend = 1.0\n[eigen]\n").empty());
  REQUIRE(notes(minimal + "[time]\nend = 2.0\n").size() == 1);
  CHECK(has(notes(minimal + "[time]\nend = 2.0\n")[0], "[time] has no effect with analysis = \"static\""));
  CHECK(has(notes(minimal + "[sewing]\nstrain = 0.3\n").at(0), "[[panel]]"));
  CHECK(notes(minimal + "[time]\nend = 2.0\n[damping]\nmass = 1.0\n[air]\nnormal_drag = 1.0\n").size() == 3);
  CHECK(notes(echo_case(parse_case(minimal, "case.toml"))).empty());
  const std::string in_mm = minimal + "[units]\nlength = \"mm\"\nmass = \"t\"\n";
  CHECK(notes(echo_case(parse_case(in_mm, "case.toml"))).empty());
}

TEST_CASE("all keys that are wrong are named at once, in the order of the file") {
  const std::string text =
      "analysis = \"static\"\n[mesh]\nfile = \"a.msh\"\nmerg = true\n[[material]]\ntype = \"isotropic\"\nyoung = -1\n"
      "poisson = 0.3\n[[support]]\ngroup = \"a\"\ntype = \"clamed\"\n[[load]]\ntype = \"pressure\"\nmagnitude = 1\n";
  const std::string said = error_of(text);
  CHECK(std::count(said.begin(), said.end(), '\n') == 3);
  std::size_t last = 0;
  for (const char* part :
       {"case.toml:4: [mesh] unknown key 'merg'", "case.toml:5: material.thickness: the key is missing",
        "case.toml:7: material.young: -1", "case.toml:11: support.type"}) {
    CHECK(said.find(part) != said.npos);
    CHECK(said.find(part) >= last);
    last = said.find(part);
  }
  std::string many = text;
  for (int k = 0; k < 20; ++k) many += fmt::format("wrong_{} = 1\n", k);
  CHECK(has(error_of(many), "and 14 more"));
  const std::string staged = text + "stages = [\"one\"]\n[[stage]]\nname = \"one\"\nanalysis = \"static\"\n";
  CHECK(!has(error_of(staged), "'stages'"));
  CHECK(has(error_of(minimal + "[[support]]\ngroup = \"a\"\ntyp = \"clamped\"\n"), "did you mean 'type'?"));
}

TEST_CASE("misspelt names are reported with line and nearest match") {
  CHECK(error_of(replaced(minimal, "young", "yuong")) ==
        "case.toml:5: [material] unknown key 'yuong': did you mean 'young'?");
  CHECK(error_with("[stpes]\n") == "case.toml:8: unknown section 'stpes': did you mean 'steps'?");
  CHECK(error_with("[[materials]]\n") == "case.toml:8: unknown section 'materials': did you mean 'material'?");
  CHECK(error_of("titel = \"x\"\n" + minimal) == "case.toml:1: unknown key 'titel': did you mean 'title'?");
  CHECK(has(error_of("[qqqqqqqq]\n" + minimal), "case.toml:1: unknown section 'qqqqqqqq': valid: units, mesh, panel"));
  CHECK(has(error_of(replaced(minimal, "\"isotropic\"", "\"isotropc\"")),
            "case.toml:4: material.type: 'isotropc': unknown value: did you mean 'isotropic'?"));
  CHECK(has(error_after("type = \"zhou_sze_2012\"", "type = \"angle\""), "did you mean 'angles'?"));
  CHECK(has(error_after("\"reaction\", ", "\"reactoin\", "), "unknown name 'reactoin': did you mean 'reaction'?"));
  CHECK(has(error_after("[\"z\", \"x\"]", "[\"w\"]"), "unknown axis 'w'"));
  CHECK(has(error_after("analysis = \"static\"", "analysis = \"modl\""),
            "case.toml:2: analysis: 'modl': unknown value: did you mean 'modal'?"));
}

TEST_CASE("a key of another type is told apart from an unknown one") {
  CHECK(has(error_with("[[load]]\ntype = \"pressure\"\nvector = [0, 0, 1]\n"),
            "case.toml:10: [load] key 'vector' does not belong to type 'pressure'; that has: type, group, magnitude, "
            "constant"));
  CHECK(has(error_with("[[support]]\ntype = \"hinged\"\ngroup = \"a\"\ncomponents = [\"x\"]\n"),
            "does not belong to type 'hinged'"));
}

TEST_CASE("sections in the wrong form") {
  CHECK(error_with("[load]\ntype = \"pressure\"\n") == "case.toml:8: section 'load' must be written [[load]]");
  CHECK(error_with("[[steps]]\n") == "case.toml:8: section 'steps' must be written [steps]");
  CHECK(error_of("mesh = 3\n") == "case.toml:1: section 'mesh' must be written [mesh]");
  CHECK(has(error_of("[mesh\n"), "case.toml:1: this is not valid TOML: "));
  CHECK(has(error_with("thickness = 2\n"), "case.toml:8: this is not valid TOML: "));  // twice
  CHECK(error_of("[mesh]\nfile = \"a.msh\"\n") == "case.toml: there is no material; add a section [[material]]");
  CHECK(has(error_of(minimal.substr(minimal.find("[[mat"))), "case.toml: mesh.file: the key is missing; Gmsh mesh"));
  CHECK(has(error_of(replaced(minimal, "young = 2.1e11\n", "")),
            "case.toml:3: material.young: the key is missing; Young's modulus"));
  CHECK(has(error_of(replaced(minimal, "type = \"isotropic\"\n", "")),
            "case.toml:3: material.type: the key is missing; choose one of: isotropic"));
}

TEST_CASE("values of the wrong type or range") {
  const auto material = [](const std::string& from, const std::string& to) {
    return error_of(replaced(minimal, from, to));
  };
  CHECK(material("0.01", "-0.01") == "case.toml:7: material.thickness: -0.01: must be > 0 [m]");
  CHECK(material("0.01", "0") == "case.toml:7: material.thickness: 0: must be > 0 [m]");
  CHECK(has(material("0.01", "nan"), "case.toml:7: material.thickness: nan: the number must be finite"));
  CHECK(has(material("2.1e11", "inf"), "case.toml:5: material.young: inf: the number must be finite"));
  CHECK(material("2.1e11", "\"2.1e11\"") ==
        "case.toml:5: material.young: '2.1e11': the unit is missing; add it, or write the number without quotes");
  CHECK(has(material("2.1e11", "[1]"), "a number in Pa > 0 is needed"));
  CHECK(material("0.3", "0.51") == "case.toml:6: material.poisson: 0.51: must be > -1 and <= 0.5");
  CHECK(has(material("0.3", "-1.0"), "case.toml:6: material.poisson: -1: must be > -1"));
  CHECK(error_of(replaced(minimal, "0.3", "0.5")) == "no error");
  CHECK(has(material("\"plate.geo\"", "\"\""), "the text is empty"));
  CHECK(has(material("\"plate.geo\"", "3"), "case.toml:2: mesh.file: 3: a text in quotes is needed"));
  CHECK(has(error_after("algorithm = 5", "algorithm = 5.5"), "mesh.algorithm: 5.5: a whole number is needed"));
  CHECK(has(error_after("n = 12", "n = \"12\""), "mesh.parameters: { L = 2.5, n = '12' }: 'n' must be a number"));
  CHECK(has(error_after("{ n = 12, L = 2.5 }", "{ }"), "the table is empty"));
  CHECK(has(error_after("fallback = false", "fallback = \"no\""), "steps.fallback: 'no': write true or false"));
  CHECK(has(error_after("cst_fraction = 0.3", "cst_fraction = 1.5"), "must be >= 0 and <= 1"));
  CHECK(has(error_after("value = [0.1, 0, -0.2]", "value = [0.1, 0]"), "three numbers [x, y, z] are needed"));
  CHECK(has(error_after("direction = [1, 1, 0]", "direction = [0, 0, 0]"), "a direction must not be zero"));
  CHECK(has(error_after("[[2, 1, 0.1], ", "[[2, 1], "), "three rows of three numbers are needed"));
  CHECK(has(error_after("every = 3", "every = 0"), "output.every: 0: must be >= 1"));
  CHECK(has(error_after("every = 3", "every = 99999999999"), "the number is too large"));
  CHECK(has(error_after("options = \"-snes", "options = \"snes"), "petsc.options: 'snes_rtol' is neither an option"));
}

TEST_CASE("lists: empty, doubled, unsorted") {
  CHECK(has(error_after("groups = [\"fabric\"]", "groups = []"),
            "material.groups: []: the list is empty; fill it or leave the key out"));
  CHECK(
      has(error_after("components = [\"z\", \"x\"]", "components = []"), "support.components: []: the list is empty"));
  CHECK(has(error_after("[\"z\", \"x\"]", "[\"z\", \"z\"]"), "axis 'z' is there twice"));
  CHECK(has(error_after("\"rim\"]", "\"plate\"]"), "'plate' is there twice"));
  CHECK(has(error_after("[\"fabric\"]", "[\"rim\"]"),
            "case.toml:22: material.groups: group 'rim' has a material already"));
  CHECK(has(error_after("groups = [\"fabric\"]\n", ""), "another material has no groups either"));
  CHECK(has(error_after("[0.1, 0.7, 2]", "[0.7, 0.1, 2]"),
            "steps.stops: 0.1 follows 0.7: list the stops in ascending order"));
  CHECK(has(error_after("[0.1, 0.7, 2]", "[0.1, 0.7, 3]"), "steps.stops: 3 lies beyond final_load_factor = 2"));
  CHECK(has(error_after("[0.1, 0.7, 2]", "[0.0, 0.7]"), "must be > 0"));
  CHECK(has(error_after("[0.1, 0.7, 2]", "0.5"), "a list of numbers is needed, in square brackets"));
}

TEST_CASE("stiffness that is not positive definite or has no direction") {
  CHECK(has(error_after("[[2, 1, 0.1], [1, 3, 0]", "[[2, 4, 0.1], [4, 3, 0]"),
            "material.membrane: the matrix is not positive definite"));
  CHECK(has(error_after("[[1, 0, 0], [0, 1, 0], [0, 0, 0.5]]", "[[1, 0, 0], [0, 1, 0], [0, 0, 0]]"),
            "material.bending: the matrix is not positive definite"));
  CHECK(
      has(error_after("[1, 3, 0]", "[1.1, 3, 0]"), "material.membrane: the matrix is not symmetric (difference 0.1)"));
  CHECK(has(error_after("poisson_12 = 0.2", "poisson_12 = 1.8"),
            "|poisson_12| must be below sqrt(young_1 / young_2) = 1.73205"));
  CHECK(error_of(replaced(full, "poisson_12 = 0.2", "poisson_12 = 1.7")) == "no error");
  CHECK(
      has(error_after("direction = [0, 0, 1]\n", ""), "material.direction: the key is missing; these matrices depend"));
  CHECK(has(error_after("direction = [1, 1, 0]\n", ""), "case.toml:21: material.direction: the key is missing"));
  CHECK(has(error_of(replaced(minimal, "2.1e11", "1e308")), "no error"));
  CHECK(has(error_of(replaced(replaced(minimal, "2.1e11", "1e308"), "0.01", "1e5")),
            "not positive definite or not finite"));
}

TEST_CASE("steps fit each other") {
  CHECK(has(error_after("initial_step = 0.1", "initial_step = 0.6"),
            "steps.initial_step: 0.6: must not be larger than max_step = 0.5"));
  CHECK(has(error_after("min_step = 1e-5", "min_step = 0.2"),
            "steps.min_step: 0.2: must not be larger than initial_step = 0.1"));
  CHECK(has(error_of(minimal + "[steps]\ninitial_step = 2\n"), "must not be larger than max_step = 1"));
  const std::string along = "[[probe]]\nname = \"p\"\ntype = \"displacement\"\ngroup = \"tip\"\ncomponents = [\"z\"]\n";
  CHECK(has(error_of(minimal + along + "[steps]\ncontrol = \"arc_length\"\ncontrol_probe = \"p\"\ninitial_step = 2\n"),
            "no error"));
  const input::Case c = parse_case(minimal + "[steps]\nmax_step = 0.1\n", "case.toml");
  CHECK(c.steps.initial_step == 0.1);
  const auto steps = [&](const std::string& text) { return parse_case(text, "case.toml").steps; };
  CHECK(steps(minimal + "[steps]\nfinal_load_factor = 8\n").max_step == 1.0);
  CHECK(steps(minimal + "[steps]\nfinal_load_factor = 5000\n").max_step == 500.0);
  CHECK(steps(minimal + "[steps]\nfinal_load_factor = 5000\n").initial_step == 125.0);
  CHECK(steps(minimal + "[steps]\nfinal_load_factor = 5000\nmax_step = 2\n").max_step == 2.0);
  const std::string modes = "analysis = \"buckling\"\n" + minimal + "[eigen]\nload_factor = 5000\n";
  CHECK(steps(modes).max_step == 500.0);
}

TEST_CASE("with contact the spectral radius of a motion is 0 if nothing else is asked for") {
  const std::string motion = "analysis = \"dynamic\"\n" + minimal, contact = "[contact]\ndistance = 1e-3\n";
  CHECK(parse_case(motion, "case.toml").time.options.radius == 0.5);
  CHECK(parse_case(motion + contact, "case.toml").time.options.radius == 0.0);
  CHECK(parse_case(motion + contact + "[time]\nspectral_radius = 0.3\n", "case.toml").time.options.radius == 0.3);
  CHECK_THROWS_WITH_AS((void)parse_case(motion + "[time]\nradius = 0.3\n", "case.toml"),
                       doctest::Contains("spectral_radius"), UserError);
}

TEST_CASE("a number is an expression where that has a unit") {
  const std::string motion = "analysis = \"dynamic\"\n" + minimal;
  const input::Case c =
      parse_case(motion +
                     "[[imperfection]]\ntype = \"expression\"\nheight = 0.125\n[[support]]\ntype = \"hinged\"\ngroup = "
                     "\"left\"\nmotion = [0, 0.25, \"2*t\"]\n",
                 "case.toml");
  CHECK(c.imperfections.front().height == "0.125");
  CHECK(c.supports.back().motion(Vec3::Zero(), 3.0) == Vec3(0.0, 0.25, 6.0));
  CHECK_THROWS_WITH_AS((void)parse_case("title = 5\n" + minimal, "case.toml"),
                       doctest::Contains("a text in quotes is needed"), UserError);
}

TEST_CASE("the balance of energy is kept unless the method is explicit or it is not wanted") {
  const std::string motion = "analysis = \"dynamic\"\n" + minimal;
  const std::string by_differences = "[time]\nmethod = \"central_difference\"\nmass = \"lumped\"\n";
  const auto kept = [](const std::string& text) { return parse_case(text, "case.toml").output.energy_balance; };
  CHECK(kept(motion));
  CHECK_FALSE(kept(motion + "[output]\nenergy_balance = false\n"));
  CHECK_FALSE(kept(motion + by_differences));
  CHECK(kept(motion + by_differences + "[output]\nenergy_balance = true\n"));
}

TEST_CASE("a section of which only --set gives a key is there") {
  const std::string motion = "analysis = \"dynamic\"\n" + minimal;
  CHECK_FALSE(input::parse_case(motion, "case.toml", {}).contact.input.active);
  CHECK(input::parse_case(motion, "case.toml", {"contact.distance=1e-3"}).contact.input.active);
  CHECK(input::parse_case(motion, "case.toml", {"remesh.smallest=0.1"}).remesh.active);
}

TEST_CASE("--set says where a stage has a value of its own") {
  const std::string staged =
      minimal + "[[stage]]\nname = \"fall\"\nanalysis = \"dynamic\"\n[stage.time]\nstep = 0.01\n";
  CHECK_THROWS_WITH_AS((void)input::parse_case(staged, "case.toml", {"time.step=0.005"}),
                       doctest::Contains("stage 'fall' has its own value, which would stay; set stage.0.time.step"),
                       UserError);
  (void)input::parse_case(staged, "case.toml", {"stage.0.time.step=0.005"});
  (void)input::parse_case(staged, "case.toml", {"time.end=0.5"});
}

TEST_CASE("probes and loads need what they observe or act on") {
  CHECK(has(error_after("name = \"pull\"", "name = \"tip\""), "probe.name: 'tip': another probe has this name"));
  CHECK(has(error_after("name = \"pull\"", "name = \"a,b\""), "must not contain commas"));
  CHECK(has(error_after("point = [0, 0, 0]\n", ""), "needs either 'group' or 'point'"));
  CHECK(
      has(error_after("point = [0, 0, 0]\n", "point = [0, 0, 0]\ngroup = \"a\"\n"), "needs either 'group' or 'point'"));
  CHECK(has(error_with("[[probe]]\nname = \"r\"\ntype = \"reaction\"\n"),
            "case.toml:8: probe.group: the key is missing"));
  CHECK(has(error_with("[[load]]\ntype = \"line\"\nvector = [0, 0, 1]\n"),
            "case.toml:8: load.group: the key is missing"));
  CHECK(has(error_with("[[load]]\ntype = \"pressure\"\n"), "case.toml:8: load.magnitude: the key is missing"));
  CHECK(has(error_with("[[support]]\ntype = \"clamped\"\n"), "case.toml:8: support.group: the key is missing"));
}

TEST_CASE("nearest names") {
  CHECK(nearest("yuong", {"young", "poisson"}) == "young");
  CHECK(nearest("thicknes", {"thickness"}) == "thickness");
  CHECK(nearest("zzz", {"young", "poisson"}).empty());
  CHECK(nearest("ab", {"xy"}).empty());
}

TEST_CASE("the command line is shared with PETSc") {
  using Words = std::vector<std::string>;
  const auto split =
      input::split_arguments({"run", "case.toml", "-snes_monitor", "-ksp_type", "cg", "--output", "out",
                              "-mat_mumps_icntl_14", "200", "-ksp_shift", "-1.5", "-options_left", "-h"});
  CHECK(split.own == Words{"run", "case.toml", "--output", "out", "-h"});
  CHECK(split.petsc ==
        Words{"-snes_monitor", "-ksp_type", "cg", "-mat_mumps_icntl_14", "200", "-ksp_shift", "-1.5", "-options_left"});
  const auto pairs = input::petsc_pairs("  -snes_rtol 1e-10\n-ksp_view -shift -2 ");
  REQUIRE(pairs.size() == 3);
  CHECK(pairs[0] == std::pair<std::string, std::string>("-snes_rtol", "1e-10"));
  CHECK(pairs[1].second.empty());
  CHECK(pairs[2].second == "-2");
  CHECK_THROWS_AS((void)input::petsc_pairs("-a1 1 2"), UserError);
}

}  // namespace test_case

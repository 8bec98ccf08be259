// What a case is echoed as, and the reference page of its keys.
#include <doctest/doctest.h>

#include <numbers>
#include <string>

#include "input/case.hpp"
#include "input/case_keys.hpp"
#include "test_case_kit.hpp"
#include "test_case_texts.hpp"

namespace test_echo {

using namespace voile;
using namespace voile::testing;
using namespace voile::testing::cases;
using input::parse_case;

namespace {

void check_equal(const input::Case& a, const input::Case& b) {
  CHECK(a.title == b.title);
  CHECK(a.analysis == b.analysis);
  CHECK(a.mesh.file == b.mesh.file);
  CHECK(a.mesh.options.parameters == b.mesh.options.parameters);
  CHECK(a.mesh.options.size == b.mesh.options.size);
  CHECK(a.mesh.options.algorithm == b.mesh.options.algorithm);
  CHECK(a.mesh.options.scale == b.mesh.options.scale);
  CHECK(a.element.bending == b.element.bending);
  CHECK(a.element.membrane == b.element.membrane);
  CHECK(a.element.cst_fraction == b.element.cst_fraction);
  CHECK(a.element.max_patch_condition == b.element.max_patch_condition);
  CHECK(a.element.crease_angle == b.element.crease_angle);
  CHECK(a.steps.final_load_factor == b.steps.final_load_factor);
  CHECK(a.steps.initial_step == b.steps.initial_step);
  CHECK(a.steps.min_step == b.steps.min_step);
  CHECK(a.steps.max_step == b.steps.max_step);
  CHECK(a.steps.stops == b.steps.stops);
  CHECK(a.steps.target_iterations == b.steps.target_iterations);
  CHECK(a.steps.fallback == b.steps.fallback);
  CHECK(a.output.fields == b.output.fields);
  CHECK(a.output.every == b.output.every);
  CHECK(a.petsc_options == b.petsc_options);
}

void check_equal_lists(const input::Case& a, const input::Case& b) {
  REQUIRE(a.materials.size() == b.materials.size());
  for (std::size_t i = 0; i < a.materials.size(); ++i) {
    CHECK(a.materials[i].groups == b.materials[i].groups);
    CHECK(a.materials[i].membrane == b.materials[i].membrane);
    CHECK(a.materials[i].bending == b.materials[i].bending);
    CHECK(a.materials[i].areal_density == b.materials[i].areal_density);
    CHECK(a.materials[i].direction == b.materials[i].direction);
  }
  REQUIRE(a.supports.size() == b.supports.size());
  for (std::size_t i = 0; i < a.supports.size(); ++i) {
    CHECK(a.supports[i].group == b.supports[i].group);
    CHECK(a.supports[i].kind == b.supports[i].kind);
    CHECK(a.supports[i].components == b.supports[i].components);
    CHECK(a.supports[i].value == b.supports[i].value);
    CHECK(a.supports[i].normal == b.supports[i].normal);
  }
  REQUIRE(a.loads.size() == b.loads.size());
  for (std::size_t i = 0; i < a.loads.size(); ++i) {
    CHECK(a.loads[i].kind == b.loads[i].kind);
    CHECK(a.loads[i].group == b.loads[i].group);
    CHECK(a.loads[i].vector == b.loads[i].vector);
    CHECK(a.loads[i].magnitude == b.loads[i].magnitude);
    CHECK(a.loads[i].constant == b.loads[i].constant);
  }
  REQUIRE(a.probes.size() == b.probes.size());
  for (std::size_t i = 0; i < a.probes.size(); ++i) {
    CHECK(a.probes[i].name == b.probes[i].name);
    CHECK(a.probes[i].kind == b.probes[i].kind);
    CHECK(a.probes[i].group == b.probes[i].group);
    CHECK(a.probes[i].point == b.probes[i].point);
    CHECK(a.probes[i].components == b.probes[i].components);
  }
}

}  // namespace

TEST_CASE("the echo reads back as the same case, from another folder") {
  for (const std::string& text : {minimal, full}) {
    const input::Case a = parse_case(text, "here/case.toml");
    const std::string echo = input::echo_case(a);
    CAPTURE(echo);
    const input::Case b = parse_case(echo, "/elsewhere/case.toml");
    check_equal(a, b);
    check_equal_lists(a, b);
    CHECK(input::echo_case(b) == echo);
  }
}

TEST_CASE("angles survive the echo to the last bit") {
  input::Case c = parse_case(minimal, "case.toml");
  for (int i = 0; i < 500; ++i) {
    c.element.crease_angle = (0.5 + i) / 500 * std::numbers::pi / 180 * (1 + i % 170);
    // Only angles that some number of degrees gives can be asked for.
    c.element.crease_angle = c.element.crease_angle / (std::numbers::pi / 180) * (std::numbers::pi / 180);
    CHECK(parse_case(input::echo_case(c), "case.toml").element.crease_angle == c.element.crease_angle);
  }
}

TEST_CASE("texts with quotes, control characters and umlauts survive the echo") {
  input::Case c = parse_case(minimal, "case.toml");
  c.title = "a\\b \"c\"\n\t\x01 \xc3\xa4";
  CHECK(parse_case(input::echo_case(c), "case.toml").title == c.title);
}

TEST_CASE("the reference page has every section and key, and its example is valid") {
  const std::string page = input::case_reference_markdown();
  for (const input::SectionInfo& section : input::sections()) CHECK(has(page, "[" + section.name + "]"));
  for (const char* key :
       {"young_1", "crease_angle", "target_iterations", "areal_density", "parameters", "analysis", "every"})
    CHECK(has(page, std::string("| `") + key + "` |"));
  CHECK(has(page, "| `max_step` | number, > 0 | - | `1.0` |"));
  const std::size_t begin = page.find("```toml\n") + 8, end = page.find("```", begin);
  const input::Case c = parse_case(page.substr(begin, end - begin), "case.toml");
  CHECK(c.supports.at(0).group == "fixed edge");
}

}  // namespace test_echo

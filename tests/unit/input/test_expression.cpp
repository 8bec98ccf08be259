// Expressions of the time and the sections of a case that use them.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "input/case.hpp"
#include "input/expression.hpp"
#include "test_case_kit.hpp"
#include "test_relative.hpp"
#include "voile/errors.hpp"

namespace test_expression {

using namespace voile;
using namespace voile::testing;
using input::expression;
using input::parse_case;

namespace {

const std::string head = R"(analysis = "dynamic"
[mesh]
file = "a.geo"
[[material]]
type = "isotropic"
young = 1e6
poisson = 0.3
thickness = 0.001
density = 300
)";

std::string error_with(const std::string& more) {
  return error_of(head + more);
}

}  // namespace

TEST_CASE("expressions know t, pi, functions and tables") {
  CHECK(expression("3")(7.0) == 3.0);
  CHECK(expression("2*t + 1")(3.0) == 7.0);
  CHECK(expression("sin(2*pi*t)")(0.25) == relative(1.0));
  const auto table = expression("table(t, 0, 1, 2, 5, 3, 4)");
  CHECK(table(-1.0) == 1.0);
  CHECK(table(0.5) == 2.0);
  CHECK(table(2.0) == 5.0);
  CHECK(table(2.5) == 4.5);
  CHECK(table(9.0) == 4.0);
  // Copies go on living when the original is gone, each with its own t.
  std::function<double(double)> kept;
  {
    const auto f = expression("t*t");
    kept = f;
    CHECK(f(2.0) == 4.0);
  }
  CHECK(kept(3.0) == 9.0);
}

TEST_CASE("expressions of columns have a value for each row") {
  const std::vector<std::string> names{"tip_z", "load factor", "n=4", "2nd", "pi"};
  const std::vector<std::vector<double>> columns{{1, 2, std::nan("")}, {4, 5, 6}, {7, 8, 9}, {1, 1, 1}, {2, 2, 2}};
  const std::vector<double> values = input::row_expression("-1000*tip_z + pi", names, columns);
  REQUIRE(values.size() == 3);
  CHECK(values[0] == -998.0);
  CHECK(values[1] == -1998.0);
  CHECK(std::isnan(values[2]));
  CHECK(input::row_expression("cos(pi)", {"a"}, {{1, 2}}) == std::vector<double>{-1, -1});
  CHECK(input::row_expression("a", {"a"}, {{}}).empty());
  CHECK(has(error_of([&] { (void)input::row_expression("2*tip_y", names, columns); }), "did you mean 'tip_z'"));
  CHECK(has(error_of([&] { (void)input::row_expression("2*(tip_z", names, columns); }), "expression such as"));
}

TEST_CASE("bad expressions say what is wrong") {
  for (const char* text : {"2*", "speed*t", "table(t, 0, 1, 2)", "table(t, 1, 0, 0, 1)", "", "1/0", "sqrt(-1)"})
    CHECK_THROWS_AS((void)expression(text), UserError);
  try {
    (void)expression("speed*t");
    FAIL("no error");
  } catch (const UserError& e) {
    CHECK(has(e.what(), "'speed*t'"));
    CHECK(has(e.what(), "write an expression of t"));
  }
}

TEST_CASE("an expression that is no number later says where it is from, and when") {
  const auto f = expression("log(0.01-t)");
  CHECK(std::isfinite(f(0.0)));
  CHECK(has(error_of([&] { (void)f(0.02); }), "'log(0.01-t)' is not a finite number at t = 0.02"));
  const input::Case c = parse_case(head + R"toml([[load]]
type = "gravity"
vector = [0, 0, -1]
history = "1/(1-t)"
)toml",
                                   "case.toml");
  CHECK(c.loads.at(0).history(0.5) == 2.0);
  const std::string said = error_of([&] { (void)c.loads.at(0).history(1.0); });
  CHECK(has(said, "case.toml:"));
  CHECK(has(said, "load.history: '1/(1-t)' is not a finite number at t = 1"));
}

TEST_CASE("a support that moves and lets go") {
  const input::Case c = parse_case(head + R"toml([[support]]
type = "hinged"
group = "edge"
motion = ["0.1*t", "0", "0"]
rotation_axis = [0, 0, 2]
rotation_centre = [1, 0, 0]
rotation_angle = "90*t"
release = 2.5
[time]
end = 3
step = 0.01
load_history = "table(t, 0, 0, 1, 1)"
[damping]
mass = 0.5
bending = 0.01
membrane = 0.001
[air]
normal_drag = 1.2
wind = [3, 0, 0]
)toml",
                                   "case.toml");
  REQUIRE(c.supports.size() == 1);
  CHECK(c.supports[0].release == 2.5);
  REQUIRE(c.supports[0].motion);
  // A quarter turn about the z axis through (1, 0, 0), and a shift.
  const Vec3 u = c.supports[0].motion(Vec3(2.0, 0.0, 0.0), 1.0);
  CHECK((u - Vec3(-1.0 + 0.1, 1.0, 0.0)).norm() < 1e-14);
  CHECK(c.dynamics.load_history(0.25) == 0.25);
  CHECK(c.dynamics.mass == system::Mass::lumped);
  CHECK(c.dynamics.mass_damping == 0.5);
  CHECK(c.dynamics.bending_damping == 0.01);
  CHECK(c.dynamics.viscous_time == 0.001);
  CHECK(c.dynamics.drag.normal == 1.2);
  CHECK(c.dynamics.drag.wind == Vec3(3.0, 0.0, 0.0));
  CHECK(c.time.options.end_time == 3.0);
  // The echo means the same.
  const input::Case again = parse_case(echo_case(c), "echo.toml");
  CHECK(echo_case(again) == echo_case(c));
  CHECK((again.supports[0].motion(Vec3(0.3, 0.2, 0.1), 0.7) - c.supports[0].motion(Vec3(0.3, 0.2, 0.1), 0.7)).norm() ==
        0.0);
}

TEST_CASE("contradictions in time sections are refused") {
  const std::string support = "[[support]]\ntype = \"hinged\"\ngroup = \"edge\"\n";
  CHECK(has(error_with(support + "motion = [\"t\", \"0\"]\n"), "three are needed"));
  CHECK(has(error_with(support + "motion = [\"t\", \"0\", \"q\"]\n"), "case.toml:13: support.motion: 'q'"));
  CHECK(has(error_with(support + "rotation_angle = \"t\"\n"), "rotation_axis and rotation_angle go together"));
  CHECK(has(error_with(support + "rotation_axis = [0, 0, 1]\n"), "rotation_axis and rotation_angle go together"));
  CHECK(has(error_with("[air]\ndensity = 1.2\n"), "air.density: without a drag coefficient"));
  CHECK(error_with("[air]\ndensity = 1.2\nnormal_drag = 0\n") == "no error");
  CHECK(has(error_with("[time]\nstep = 0.1\nmax_step = 0.01\n"), "must not be smaller than step"));
  CHECK(has(error_with("[time]\nstep = 0.1\nmin_step = 0.2\n"), "must not be larger than step"));
  CHECK(has(error_with("[time]\nmethod = \"central_difference\"\nmass = \"consistent\"\n"), "needs mass = \"lumped\""));
  CHECK(has(error_with("[time]\nmass = \"consistent\"\n" + support + "motion = [\"t\", \"0\", \"0\"]\n"),
            "time.mass: held vertices"));
  const std::string pushed =
      "[[support]]\ntype = \"displacement\"\ngroup = \"edge\"\ncomponents = [\"x\"]\nvalue = [0.1, 0, 0]\n";
  CHECK(error_with("[time]\nmass = \"consistent\"\n" + pushed) == "no error");  // held where it is
  CHECK(has(error_with("[time]\nmass = \"consistent\"\nload_history = \"t\"\n" + pushed), "time.mass: held vertices"));
  CHECK(has(error_with("[time]\nload_history = \"x\"\n"), "time.load_history"));
  std::string still = head;
  still.replace(still.find("dynamic"), 7, "static");
  const std::string moving = support + "motion = [\"t\", \"0\", \"0\"]\n";
  CHECK(error_of(still + moving) == "no error");  // t is the load factor then
  CHECK(has(error_of(still + moving + "[steps]\ncontrol = \"arc_length\"\n"), "steps.control: supports with a motion"));
  for (const char* other : {"linear", "buckling", "modal"}) {
    std::string text = head;
    text.replace(text.find("dynamic"), 7, other);
    CHECK(has(error_of(text + moving),
              "support.motion: something moves only with analysis = \"dynamic\", \"static\" or \"drape\""));
  }
  const std::string floor =
      "[[obstacle]]\nname = \"floor\"\ntype = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n"
      "rotation_axis = [1, 0, 0]\nrotation_angle = \"t\"\n";
  CHECK(parse_case(still + floor, "case.toml").moves_obstacles_by_load());
  std::string draped = head;
  draped.replace(draped.find("dynamic"), 7, "drape");
  CHECK(has(error_of(draped + floor), "obstacle.rotation_angle: something moves only with analysis = \"dynamic\" or"));
  const std::string clamp =
      replaced(moving, "hinged", "clamped") + "rotation_axis = [0, 2, 0]\nrotation_angle = \"90*t\"\n";
  const input::Case turning = parse_case(still + clamp, "case.toml");
  REQUIRE(turning.supports[0].rotation);
  CHECK((turning.supports[0].rotation(1.0) * Vec3::UnitX() + Vec3::UnitZ()).norm() < 1e-15);
  CHECK(has(error_of(still + support + "release = 1\n"), "only with analysis = \"dynamic\""));
  const std::string held =
      "[contact]\ndistance = 0.01\n[[obstacle]]\nname = \"pole\"\ntype = \"cylinder\"\npoint = [0, 0, 0]\n"
      "end = [0, 0, 1]\nradius = 0.1\n[[attachment]]\ngroups = [\"left\"]\nobstacle = \"pole\"\n";
  CHECK(error_of(still + held) == "no error");
  CHECK(has(error_of(still + held + "release = 1\n"),
            "attachment.release: an attachment releases only with analysis = \"dynamic\""));
  CHECK(error_of(head + held + "release = 1\n") == "no error");
}

TEST_CASE("who writes if(...) is told how conditions are written") {
  for (const char* text : {"if(t > 1, 2, 3)", "1 + if (t > 1, 2, 3)"})
    CHECK(has(error_of([&] { (void)input::expression(text); }), "t > 1 ? 2 : 3"));
  CHECK(input::expression("t > 1 ? 2 : 3")(2.0) == 2.0);
  CHECK_FALSE(has(error_of([] { (void)input::expression("shift(t)"); }), "?"));
}

TEST_CASE(
    "a decimal comma and a single = are refused wherever expressions are, where muParser would take the last number") {
  for (const char* text : {"0,01", "0,01*x", "1,5 + 2"}) {
    CHECK(has(error_of([&] { (void)input::place_expression(text, false); }), "decimals have a point"));
    CHECK(has(error_of([&] { (void)input::size_expression(text); }), "decimals have a point"));
  }
  CHECK(has(error_of([] { (void)input::expression("0,01*t"); }), "2 numbers"));
  CHECK(has(error_of([] { (void)input::row_expression("1,5*a", {"a"}, {{1.0, 2.0}}); }), "decimals have a point"));
  for (const char* text : {"t = 5", "t=5", "t += 1", "(t = 1) + t", "=1", "1="})
    CHECK(has(error_of([&] { (void)input::expression(text); }), "="));
  CHECK(has(error_of([] { (void)input::place_expression("x = 2", false); }), "sets nothing"));
  CHECK(input::expression("(t == 1) + (t >= 1) + (t <= 1) + (t != 2)")(1.0) == 4.0);
  CHECK(input::expression("max(1, 2*t)")(3.0) == 6.0);
  CHECK(has(error_of([] { (void)input::size_expression("1/x")(Vec3::Zero()); }), "not a finite number"));
}

TEST_CASE("path control is checked against the probes") {
  std::string text = head;
  text.replace(text.find("dynamic"), 7, "static");
  const std::string probe = "[[probe]]\nname = \"C\"\ntype = \"displacement\"\ngroup = \"C\"\ncomponents = [\"z\"]\n";
  const input::Case c =
      parse_case(text + probe + "[steps]\ncontrol = \"arc_length\"\ncontrol_probe = \"C\"\nfinal_displacement = -1\n",
                 "case.toml");
  CHECK(c.steps.control == solve::StaticOptions::Control::arc_length);
  CHECK(c.steps.target_iterations == 5);
  CHECK(c.steps.max_step == 1e9);
  const auto error = [&](const std::string& steps) { return error_of(text + probe + "[steps]\n" + steps); };
  CHECK(has(error("control = \"displacement\"\n"), "control_probe"));
  CHECK(has(error("control = \"displacement\"\ncontrol_probe = \"C\"\n"), "final_displacement"));
  CHECK(has(error("control = \"arc_length\"\ncontrol_probe = \"D\"\n"), "there is no probe 'D'"));
  CHECK(has(error("control = \"arc_length\"\nstops = [0.5]\n"), "belong to control = \"load\""));
  CHECK(has(error("control_probe = \"C\"\n"), "has no probe"));
  CHECK(has(error("at_critical_point = \"stop\"\n"), "cannot stop or branch"));
  CHECK(has(error("control = \"displacement\"\ncontrol_probe = \"C\"\nfinal_displacement = 1\nat_critical_point = "
                  "\"switch_branch\"\n"),
            "under control = \"arc_length\" only"));
  CHECK(has(error("control = \"arc_length\"\nbranch_step = 0\n"), "branch_step"));
}

}  // namespace test_expression

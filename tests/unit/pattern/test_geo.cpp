// Pieces drawn in Gmsh scripts: their curves, names, holes and parameters.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "test_pattern_kit.hpp"
#include "test_relative.hpp"

namespace test_geo {

using namespace voile;
using namespace voile::testing;

namespace {

constexpr double pi = std::numbers::pi;

/// A half disc with a square hole, a quarter of an ellipse, and a strip under a cubic.
const char* const script = R"(
DefineConstant[ r = {0.2, Name "Parameters/r"} ];
Point(1) = {0, 0, 3}; Point(2) = {r, 0, 3}; Point(3) = {0, r, 3}; Point(4) = {-r, 0, 3};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Line(3) = {4, 2};
Point(5) = {-0.02, 0.05, 3}; Point(6) = {0.02, 0.05, 3}; Point(7) = {0.02, 0.09, 3}; Point(8) = {-0.02, 0.09, 3};
Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 8}; Line(8) = {8, 5};
Curve Loop(1) = {1, 2, 3}; Curve Loop(2) = {5, 6, 7, 8};
Plane Surface(1) = {1, 2};
Point(11) = {1, 0, 3}; Point(12) = {1.4, 0, 3}; Point(13) = {1, 0.3, 3};
Ellipse(11) = {12, 11, 12, 13}; Line(12) = {13, 11}; Line(13) = {11, 12};
Curve Loop(11) = {11, 12, 13};
Plane Surface(2) = {11};
Point(21) = {2, 0, 3}; Point(22) = {2.5, 0, 3}; Point(23) = {2.5, 0.2, 3}; Point(24) = {2, 0.1, 3};
Point(25) = {2.3, 0.5, 3}; Point(26) = {2.1, -0.1, 3};
Line(21) = {21, 22}; Line(22) = {22, 23}; Bezier(23) = {23, 25, 26, 24}; Line(24) = {24, 21};
Curve Loop(21) = {-24, -23, -22, -21};
Plane Surface(3) = {21};
Physical Surface("half") = {1}; Physical Surface("quarter") = {2}; Physical Surface("strip") = {3};
Physical Curve("straight") = {3}; Physical Point("left") = {4};
)";

}  // namespace

TEST_CASE("geo pattern: areas and lengths are those of the curves") {
  const pattern::Pattern p = read("pieces.geo", script);
  REQUIRE(p.pieces.size() == 3);
  const pattern::Piece &half = p.pieces[0], &quarter = p.pieces[1], &strip = p.pieces[2];
  CHECK(half.name == "half");
  CHECK(half.loops().size() == 2);
  CHECK(std::abs(half.signed_area()) == relative(pi * 0.04 / 2 - 0.0016).epsilon(1e-9));
  CHECK(half.edges[0].curve.length() == relative(pi * 0.1).epsilon(1e-9));
  CHECK(half.edges[2].curve.is_line());
  CHECK(half.edges[2].label == "straight");
  REQUIRE(half.point_names.size() == 7);
  CHECK(half.point_names[2] == "left");
  CHECK((half.point(2) - Vec2(-0.2, 0.0)).norm() < 1e-15);
  CHECK(std::abs(quarter.signed_area()) == relative(pi * 0.4 * 0.3 / 4).epsilon(1e-9));
  // The complete elliptic integral E(m), m = 1 - (0.3/0.4)^2 = 0.4375: 0.4 E.
  CHECK(quarter.edges[0].curve.length() == relative(0.4 * std::comp_ellint_2(std::sqrt(0.4375))).epsilon(1e-9));
  const pattern::Curve cubic = pattern::Curve::bezier({{2.5, 0.2}, {2.3, 0.5}, {2.1, -0.1}, {2.0, 0.1}});
  double found = 0.0;
  for (const pattern::Edge& e : strip.edges)
    if (!e.curve.is_line()) found = e.curve.length();
  CHECK(found == relative(cubic.length()).epsilon(1e-9));
  double area = 0.0;
  for (const pattern::Curve& c :
       {pattern::Curve::bezier({{2.0, 0.0}, {2.5, 0.0}}), pattern::Curve::bezier({{2.5, 0.0}, {2.5, 0.2}}), cubic,
        pattern::Curve::bezier({{2.0, 0.1}, {2.0, 0.0}})})
    area += c.area();
  CHECK(std::abs(strip.signed_area()) == relative(area).epsilon(1e-9));
}

TEST_CASE("geo pattern: units, parameters, some of the pieces") {
  pattern::ReadOptions options;
  options.unit = 0.01;
  options.pieces = {"half"};
  options.parameters = {{"r", 0.3}};
  const pattern::Pattern p = read("pieces.geo", script, options);
  REQUIRE(p.pieces.size() == 1);
  CHECK(p.pieces[0].edges[2].curve.length() == relative(0.006).epsilon(1e-12));
}

TEST_CASE("geo pattern: what is wrong is told") {
  const auto fails = [](const std::string& text, const pattern::ReadOptions& options, const std::string& part) {
    const std::string said = refusal("pieces.geo", text, options);
    CAPTURE(said);
    CHECK(has(said, part));
  };
  pattern::ReadOptions other, wrong;
  other.pieces = {"sleeve"};
  wrong.parameters = {{"q", 1.0}};
  fails(script, other, "there is no piece 'sleeve'; those found: half, quarter, strip");
  fails(script, wrong, "there is no parameter 'q'");
  fails("Point(1) = {0, 0, 0};\n", {}, "there is no surface");
  fails(fmt::format("SystemCall \"true\";\n{}", script), {}, "--allow-system-call");
  std::string tilted = script;
  tilted.replace(tilted.find("Point(8) = {-0.02, 0.09, 3}"), 27, "Point(8) = {-0.02, 0.09, 4}");
  fails(tilted, {}, "does not lie in a plane of constant z");
  fails("Point(1) = {0, 0, ;\n", {}, "Gmsh failed while reading");
}

}  // namespace test_geo

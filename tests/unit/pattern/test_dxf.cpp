#include <doctest/doctest.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "test_pattern_kit.hpp"

namespace test_dxf {

using namespace voile;
using namespace voile::testing;

namespace {

using Words = std::vector<std::pair<int, std::string>>;

std::string groups(const Words& words) {
  std::string text;
  for (const auto& [code, value] : words) text += fmt::format("{:>3}\n{}\n", code, value);
  return text;
}

std::string pairs(int first, const std::vector<Vec2>& points) {
  std::string text;
  for (const Vec2& x : points)
    text += groups({{first, fmt::format("{}", x[0])}, {first + 10, fmt::format("{}", x[1])}});
  return text;
}

/// An entity of a layer and what else it has.
std::string entity(const std::string& type, const std::string& layer, const std::string& more) {
  return groups({{0, type}, {8, layer}}) + more;
}

std::string section(const std::string& name, const std::string& content) {
  return groups({{0, "SECTION"}, {2, name}}) + content + groups({{0, "ENDSEC"}});
}

std::string header(int units) {
  return section("HEADER", groups({{9, "$INSUNITS"}, {70, std::to_string(units)}}));
}

std::string drawing(const std::string& content, const std::string& head = header(4)) {
  return head + section("ENTITIES", content) + groups({{0, "EOF"}});
}

std::string block(const std::string& name, const std::string& content) {
  return groups({{0, "BLOCK"}, {8, "1"}, {2, name}, {70, "0"}}) + content + groups({{0, "ENDBLK"}});
}

std::string blocks(const std::string& content, const std::string& head = header(4)) {
  return head + section("BLOCKS", content) + groups({{0, "EOF"}});
}

/// As releases before 14 have it.
std::string polyline(const std::string& layer, const std::vector<Vec2>& points, bool closed = true) {
  std::string text = entity("POLYLINE", layer, groups({{66, "1"}, {70, closed ? "1" : "0"}}));
  for (const Vec2& x : points) text += entity("VERTEX", layer, pairs(10, {x}));
  return text + groups({{0, "SEQEND"}});
}

std::string marks(const std::string& layer, const std::vector<Vec2>& points) {
  std::string text;
  for (const Vec2& x : points) text += entity("POINT", layer, pairs(10, {x}));
  return text;
}

std::string line(const std::string& layer, const Vec2& a, const Vec2& b) {
  return entity("LINE", layer, pairs(10, {a}) + pairs(11, {b}));
}

pattern::Piece piece(const std::string& text, const pattern::ReadOptions& o = {}) {
  return read("pattern.dxf", text, o).pieces.at(0);
}

double length(const pattern::Piece& p) {
  double sum = 0.0;
  for (const pattern::Edge& e : p.edges) sum += e.curve.length();
  return sum;
}

const std::vector<Vec2> square{{0, 0}, {200, 0}, {200, 200}, {0, 200}};

}  // namespace

TEST_CASE("DXF: curves to 1e-9 against closed forms") {
  constexpr double pi = std::numbers::pi;
  // A polyline whose lower side bulges by half a circle, its right side by an arc of 60 degrees inwards.
  const double bulge = -std::tan(pi / 12.0);
  const std::string light = entity("LWPOLYLINE", "front",
                                   groups({{90, "4"}, {70, "1"}}) + pairs(10, {square[0]}) + groups({{42, "1"}}) +
                                       pairs(10, {square[1]}) + groups({{42, fmt::format("{}", bulge)}}) +
                                       pairs(10, {square[2]}) + groups({{42, "0"}}) + pairs(10, {square[3]}));
  const pattern::Piece p = piece(drawing(light));
  const double segment = 0.5 * 0.04 * (pi / 3.0 - std::sin(pi / 3.0));  // radius 0.2 m
  CHECK(p.name == "front");
  CHECK(std::abs(p.signed_area() - (0.04 + 0.5 * pi * 0.01 - segment)) < 1e-9);
  CHECK(std::abs(p.edges[0].curve.length() - 0.1 * pi) < 1e-9);
  CHECK(std::abs(p.edges[1].curve.length() - 0.2 * pi / 3.0) < 1e-9);

  // Lines and an arc in any order and direction.
  const std::string chain =
      line("b", {0, 0}, {0, 200}) + line("b", {200, 200}, {0, 200}) +
      entity("ARC", "b", pairs(10, {{100, 0}}) + groups({{40, "100"}, {50, "180"}, {51, "360"}})) +
      line("b", {200, 0}, {200, 200});
  const pattern::Piece joined = piece(drawing(chain));
  CHECK(joined.edges.size() == 4);
  CHECK(std::abs(std::abs(joined.signed_area()) - (0.04 + 0.5 * pi * 0.01)) < 1e-9);
  CHECK(std::abs(length(joined) - (0.6 + 0.1 * pi)) < 1e-9);

  // A quarter of a turned ellipse and two lines to its centre; a circle; an arc seen from below.
  const std::string quarter = entity("ELLIPSE", "c",
                                     pairs(10, {{0, 0}}) + pairs(11, {{60, 80}}) +
                                         groups({{40, "0.5"}, {41, "0"}, {42, fmt::format("{}", 0.5 * pi)}})) +
                              line("c", {0, 0}, {60, 80}) + line("c", {0, 0}, {-40, 30});
  CHECK(std::abs(std::abs(piece(drawing(quarter)).signed_area()) - 0.25 * pi * 0.1 * 0.05) < 1e-9);
  const std::string circle = entity("CIRCLE", "d", pairs(10, {{50, 50}}) + groups({{40, "100"}}));
  CHECK(std::abs(length(piece(drawing(circle))) - 0.2 * pi) < 1e-9);
  const std::string below =
      entity("ARC", "e", pairs(10, {{-100, 0}}) + groups({{40, "100"}, {50, "0"}, {51, "180"}, {230, "-1"}})) +
      line("e", {0, 0}, {200, 0});
  CHECK(std::abs(std::abs(piece(drawing(below)).signed_area()) - 0.5 * pi * 0.01) < 1e-9);
}

TEST_CASE("DXF: a spline is the polynomials it consists of") {
  // Two cubic spans with a knot in the middle: y = x^2 (in units of 100 mm) on 0..2 has the polar form (x1 x2 + ...)/3.
  const std::vector<double> knots{0, 0, 0, 0, 1, 2, 2, 2, 2};
  std::string text = groups({{70, "8"}, {71, "3"}});
  for (const double k : knots) text += groups({{40, fmt::format("{}", k)}});
  for (std::size_t i = 0; i < 5; ++i) {
    const double a = knots[i + 1], b = knots[i + 2], c = knots[i + 3];
    text += pairs(10, {{100.0 * (a + b + c) / 3.0, 100.0 * (a * b + b * c + a * c) / 3.0}});
  }
  const std::string outline =
      entity("SPLINE", "S", text) + line("S", {200, 400}, {0, 400}) + line("S", {0, 400}, {0, 0});
  const pattern::Piece p = piece(drawing(outline));
  CHECK(p.edges.size() == 3);
  CHECK(std::abs(p.signed_area() - 2.0 / 3.0 * 0.2 * 0.4) < 1e-9);
  const double arc = 0.1 * (0.25 * (4.0 * std::sqrt(17.0) + std::asinh(4.0)));  // of y = x^2 up to x = 2
  CHECK(std::abs(p.edges[0].curve.length() - arc) < 1e-9);
  CHECK(std::abs(p.edges[0].curve.at(p.edges[0].curve.parameters_at({0.5}).front())[1] * 10.0 -
                 std::pow(p.edges[0].curve.at(p.edges[0].curve.parameters_at({0.5}).front())[0] * 10.0, 2)) < 1e-9);
}

TEST_CASE("DXF: blocks of AAMA are pieces with corners, notches, grain line and sew line") {
  // The boundary is 10 mm outside the seam; turn points tell the corners, between which the right side is bent.
  const std::vector<Vec2> outer{{-10, -10}, {210, -10}, {210, 210}, {-10, 210}};
  const std::string content = polyline("1", outer) +
                              polyline("14", {{0, 0}, {200, 0}, {205, 100}, {200, 200}, {0, 200}}) +
                              marks("2", {{0, 0}, {200, 0}, {200, 200}, {0, 200}}) + marks("4", {{100, -10}, {0, 50}}) +
                              line("7", {50, 50}, {150, 50}) + entity("TEXT", "1", groups({{1, "Piece Name: FRONT"}}));
  const pattern::Piece p = piece(blocks(block("B1", content)));
  CHECK(p.name == "FRONT");
  REQUIRE(p.edges.size() == 6);
  CHECK(p.point_names == std::vector<std::string>{"c0", "n0", "c1", "c2", "c3", "n1"});
  CHECK((p.point(1) - Vec2(0.1, 0.0)).norm() < 1e-9);
  CHECK((p.point(5) - Vec2(0.0, 0.05)).norm() < 1e-9);
  CHECK(std::abs(p.signed_area() - (0.04 + 0.0005)) < 1e-9);
  CHECK(std::abs(p.edges[2].curve.length() - 2.0 * std::hypot(0.005, 0.1)) < 1e-9);
  CHECK((p.grain - Vec2(1, 0)).norm() < 1e-12);
  // Without a sew line the boundary is sewn.
  const pattern::Piece all = piece(blocks(block("B1", polyline("1", outer))));
  CHECK(all.name == "B1");
  CHECK(std::abs(all.signed_area() - 0.22 * 0.22) < 1e-9);
}

TEST_CASE("DXF: a notch beside no outline, and a file that does not end, are told") {
  const std::vector<Vec2> outline{{0, 0}, {200, 0}, {200, 300}, {0, 300}};
  const auto notes = [](const std::string& text) { return read("p.dxf", text).notes; };
  const std::string near = polyline("1", outline) + marks("4", {{100, 10}}), far = near + marks("4", {{500, 500}});
  CHECK(notes(blocks(block("B", near))).empty());
  const std::vector<std::string> told = notes(blocks(block("B", far)));
  REQUIRE(told.size() == 1);
  CHECK(has(told[0], "block 'B': a notch, (500, 500)"));
  const std::string whole = drawing(polyline("a", outline));
  CHECK(notes(whole).empty());
  REQUIRE(notes(whole.substr(0, whole.size() - groups({{0, "EOF"}}).size())).size() == 1);
  CHECK(has(refusal("p.dxf", "\xff\xfe" + whole), "UTF-16"));
}

TEST_CASE("DXF: points nearer than ends that meet are one, and slits are notches") {
  const auto of = [](const std::vector<Vec2>& outline) { return piece(blocks(block("B", polyline("1", outline)))); };
  const pattern::Piece plain = of({{0, 0}, {400, 0}, {400, 500}, {0, 500}});
  REQUIRE(plain.edges.size() == 4);
  for (const std::vector<Vec2>& outline :
       {std::vector<Vec2>{{0, 0}, {200, 0}, {200.0001, 0}, {400, 0}, {400, 500}, {0, 500}},
        {{0, 0}, {200, 0}, {200.0025, 0}, {200, 0}, {400, 0}, {400, 500}, {0, 500}},
        {{0, 0}, {200, 0.0001}, {200, 0}, {200, 0}, {400, 0}, {400, 500}, {0, 500}},
        {{0, 0}, {400, 0}, {400, 500}, {0, 500}, {0, 1e-4}}}) {
    const pattern::Piece p = of(outline);
    CHECK(p.edges.size() == 4);
    CHECK(std::abs(p.signed_area() - 0.2) < 1e-6);
  }
  // In the middle of a side, of two segments, with the first corner, or the last one, as its tip.
  for (const std::vector<Vec2>& outline :
       {std::vector<Vec2>{{0, 0}, {200, 0}, {200, 10}, {200, 0}, {400, 0}, {400, 500}, {0, 500}},
        {{0, 0}, {200, 0}, {200, 5}, {203, 10}, {200, 5}, {200, 0}, {400, 0}, {400, 500}, {0, 500}},
        {{200, 10}, {200, 0}, {400, 0}, {400, 500}, {0, 500}, {0, 0}, {200, 0}},
        {{200, 0}, {400, 0}, {400, 500}, {0, 500}, {0, 0}, {200, 0}, {200, 10}}}) {
    const pattern::Piece p = of(outline);
    REQUIRE(p.edges.size() == 5);
    CHECK(std::count(p.point_names.begin(), p.point_names.end(), "n0") == 1);
    const auto n =
        static_cast<std::size_t>(std::find(p.point_names.begin(), p.point_names.end(), "n0") - p.point_names.begin());
    CHECK((p.point(n) - Vec2(0.2, 0.0)).norm() < 1e-9);
    CHECK(std::abs(p.signed_area() - 0.2) < 1e-9);
  }
}

TEST_CASE("DXF: slits whose sides are lines of their own are notches, though the sides are apart or crossed") {
  // As programs of patterns export them: the sides on the same places, 0.025 mm across each other, or 0.006 mm apart, which is
  // more than ends that are joined may be.
  for (const double across : {0.0, 0.0125, -0.003, -0.0025}) {
    const Vec2 in(200 + across, 0), out(200 - across, 0), tip(200, 10);
    const std::vector<std::vector<Vec2>> lines{
        {{0, 500}, {0, 0}}, {{0, 0}, {100, 0}, in},    {in, tip},
        {tip, out},         {out, {300, 0}, {400, 0}}, {{400, 0}, {400, 500}, {0, 500}}};
    std::string content;
    for (const std::vector<Vec2>& line : lines) content += polyline("1", line, false);
    const pattern::Piece p = piece(blocks(block("B", content)));
    CAPTURE(across);
    REQUIRE(p.edges.size() == 5);
    CHECK(std::count(p.point_names.begin(), p.point_names.end(), "n0") == 1);
    CHECK(std::abs(p.signed_area()) == doctest::Approx(0.2).epsilon(1e-9));
  }
  // A notch of 2 mm has a shape, and a line that is there twice between others is a mistake.
  const std::vector<Vec2> notched{{0, 0}, {199, 0}, {200, 10}, {201, 0}, {400, 0}, {400, 500}, {0, 500}};
  CHECK(std::abs(piece(blocks(block("B", polyline("1", notched)))).signed_area()) ==
        doctest::Approx(0.19999).epsilon(1e-9));
  const std::string twice =
      polyline("1", {{0, 0}, {400, 0}, {400, 500}, {0, 500}}) + polyline("1", {{0, 0}, {400, 0}}, false);
  CHECK(has(refusal("p.dxf", blocks(block("B", twice))), "three curves or more meet"));
}

TEST_CASE("DXF: a step back of less than 2e-4 of the outline is the hand, a longer one is shape") {
  const auto with_hook = [](double back) {
    return blocks(block("B", polyline("1", {{0, 0},
                                            {200, 0},
                                            {200, 100},
                                            {120, 100},
                                            {120 + back, 100 + 0.3 * back},
                                            {100, 100 - 0.1 * back},
                                            {0, 100}})));
  };
  const pattern::Piece p = piece(with_hook(0.03));
  CHECK(p.edges.size() == 4);
  CHECK(std::abs(p.signed_area()) == doctest::Approx(0.02).epsilon(1e-4));
  CHECK(piece(with_hook(3.0)).edges.size() > 4);
}

TEST_CASE("DXF: pieces of one size of a nest go by their names") {
  const auto sized = [](const std::string& size, double width) {
    const std::string texts = entity("TEXT", "1", groups({{1, "Piece Name: FRONT"}})) +
                              entity("TEXT", "1", groups({{1, "Size: " + size + " "}}));
    return block("*U" + size, polyline("1", {{0, 0}, {width, 0}, {width, 100}, {0, 100}}) + texts);
  };
  const std::string nest = blocks(sized("36", 180) + sized("38", 200) + sized("40", 220));
  pattern::ReadOptions o;
  CHECK(read("p.dxf", nest, o).pieces.size() == 3);
  o.nest_size = "38";
  o.pieces = {"FRONT"};
  const pattern::Piece p = piece(nest, o);
  CHECK(p.name == "FRONT");
  CHECK(std::abs(p.signed_area()) == doctest::Approx(0.02));
  o.pieces = {"BACK"};
  CHECK(has(refusal("p.dxf", nest, o), "`pieces` names none of those there are: FRONT"));
  o.nest_size = "42";
  CHECK(has(refusal("p.dxf", nest, o), "no block is of this size; there are 36, 38, 40"));
  CHECK(has(refusal("p.dxf", blocks(block("B", polyline("1", {{0, 0}, {1, 0}, {1, 1}}))), o), "no block has a text"));
  CHECK(has(refusal("p.dxf", drawing(polyline("1", {{0, 0}, {1, 0}, {1, 1}})), o), "its pieces are no blocks"));
  CHECK(has(refusal("p.svg", "<svg/>", o), "only a .dxf has sizes"));
}

TEST_CASE("DXF: notches on the mirror line leave it whole") {
  const std::string half = polyline("1", {{0, 0}, {400, 0}, {400, 500}, {0, 500}}) + line("6", {0, 500}, {400, 500});
  for (const double x : {5.0, 200.0, 395.0}) {
    const pattern::Piece p = piece(blocks(block("B", half + marks("4", {{x, 500}, {200, 0}}))));
    CHECK(p.edges.size() == 8);
    CHECK(std::abs(p.signed_area() - 0.4) < 1e-9);
  }
  const std::vector<std::string> told = read("p.dxf", blocks(block("B", half + marks("4", {{200, 500}})))).notes;
  REQUIRE(told.size() == 2);
  CHECK(has(told[0], "on the mirror line"));
}

TEST_CASE("DXF: one size that is wrong does not keep the others of a nest away") {
  const std::vector<Vec2> good{{0, 0}, {200, 0}, {200, 300}, {0, 300}}, eight{{0, 0}, {200, 300}, {200, 0}, {0, 300}};
  const std::string open = polyline("1", good, false);
  for (const std::string& bad : {polyline("1", eight), open}) {
    const std::string nest =
        blocks(block("S", polyline("1", good)) + block("M", bad) + block("L", polyline("1", good)));
    const pattern::Pattern p = read("p.dxf", nest);
    CHECK(p.pieces.size() == 2);
    REQUIRE(p.notes.size() == 1);
    CHECK(has(p.notes[0], "left out"));
    CHECK(has(p.notes[0], "'M'"));
    CHECK(has(refusal("p.dxf", blocks(block("M", bad))), "'M'"));
    CHECK(has(refusal("p.dxf", blocks(block("M", bad) + block("N", bad))), "'M'"));
  }
}

TEST_CASE("DXF: a half unfolds across its mirror line") {
  const std::vector<Vec2> half{{0, 0}, {100, 0}, {120, 200}, {0, 180}};
  const std::string closed = polyline("1", half) + line("6", {0, 190}, {0, -10}) + marks("4", {{110, 100}});
  const pattern::Piece p = piece(blocks(block("B", closed)));
  CHECK(p.edges.size() == 8);
  CHECK(std::abs(p.signed_area() - 2.0 * 1e-6 * 0.5 * (100.0 * 200 + (120.0 * 180 - 0))) < 1e-9);
  CHECK(p.point_names == std::vector<std::string>{"c0", "c1", "n0", "c2", "c3", "c2'", "n0'", "c1'"});
  for (std::size_t k = 0; k < 8; ++k) CHECK((p.edges[k].curve.end() - p.point(k + 1)).norm() < 1e-12);
  // A sew line that ends at the fold.
  const std::string open =
      polyline("14", {{0, 0}, {100, 0}, {100, 100}, {0, 100}}, false) + line("6", {0, 0}, {0, 100});
  CHECK(std::abs(std::abs(piece(blocks(block("B", open))).signed_area()) - 0.02) < 1e-9);
  CHECK(has(refusal("p.dxf", blocks(block("B", polyline("1", half) + line("6", {50, 0}, {50, 100})))), "mirror line"));
}

TEST_CASE("DXF: outlines within outlines and cutouts are holes") {
  const std::string circle = entity("CIRCLE", "a", pairs(10, {{60, 60}}) + groups({{40, "30"}}));
  const auto read_all = [](const std::string& text) { return read("p.dxf", text).pieces; };
  // A piece beside it, and one within the hole.
  const std::vector<pattern::Piece> pieces =
      read_all(drawing(circle + polyline("a", square) + polyline("a", {{300, 0}, {400, 0}, {400, 100}, {300, 100}}) +
                       polyline("a", {{50, 50}, {70, 50}, {70, 70}, {50, 70}})));
  REQUIRE(pieces.size() == 3);
  CHECK(pieces[0].name == "a-0");
  CHECK(std::abs(pieces[0].signed_area() - (0.04 - 9e-4 * std::numbers::pi)) < 1e-9);
  CHECK(pieces[0].edges.size() == 6);
  CHECK(std::abs(pieces[1].signed_area() - 0.01) < 1e-12);
  CHECK(std::abs(pieces[2].signed_area() - 4e-4) < 1e-12);
  const pattern::Piece only = piece(drawing(polyline("a", square) + circle));
  CHECK(only.name == "a");
  CHECK(only.loops().size() == 2);
  // Layer 11 of a block, drawn to half: a hole beside the fold and one across it.
  const std::string half = polyline("1", {{0, 0}, {100, 0}, {100, 200}, {0, 200}}) + line("6", {0, 210}, {0, -10});
  const std::string beside = polyline("11", {{30, 30}, {60, 30}, {60, 60}, {30, 60}}),
                    across = polyline("11", {{0, 100}, {20, 100}, {20, 150}, {0, 150}}, false);
  const pattern::Piece p = piece(blocks(block("B", half + beside + across)));
  CHECK(p.loops().size() == 4);
  CHECK(std::abs(p.signed_area() - (0.04 - 2.0 * 9e-4 - 0.04 * 0.05)) < 1e-12);
  CHECK(p.point_names == std::vector<std::string>{"c0",   "c1",   "c2",   "c3",    "c2'",   "c1'",   "h0c0",
                                                  "h0c1", "h0c2", "h0c3", "h0c0'", "h0c3'", "h0c2'", "h0c1'",
                                                  "h1c0", "h1c1", "h1c2", "h1c3",  "h1c2'", "h1c1'"});
  const std::string outside = polyline("11", {{150, 30}, {160, 30}, {160, 40}});
  CHECK(has(refusal("p.dxf", blocks(block("B", half + outside))), "outside of the outline"));
  CHECK(has(refusal("p.dxf", blocks(block("B", half + line("11", {30, 30}, {60, 60})))),
            "layer 11: the outline is open"));
}

TEST_CASE("DXF: the unit is stated or asked for") {
  const std::string content = polyline("front", square);
  const auto side = [&](const std::string& head, const pattern::ReadOptions& o = {}) {
    return piece(drawing(content, head), o).edges[0].curve.length();
  };
  const auto measurement = [](const std::string& x) {
    return section("HEADER", groups({{9, "$MEASUREMENT"}, {70, x}}));
  };
  CHECK(side(header(4)) == doctest::Approx(0.2));
  CHECK(side(header(5)) == doctest::Approx(2.0));
  CHECK(side(header(1)) == doctest::Approx(5.08));
  CHECK(side(measurement("1")) == doctest::Approx(0.2));
  CHECK(side(header(4), {.unit = 0.01}) == doctest::Approx(2.0));
  CHECK(side(entity("TEXT", "1", "").substr(0, 0) + section("X", ""), {.unit = 0.001}) == doctest::Approx(0.2));
  const std::string english = entity("TEXT", "front", groups({{1, "Units: ENGLISH"}}));
  CHECK(piece(drawing(content + english, "")).edges[0].curve.length() == doctest::Approx(5.08));
  for (const std::string& head : {std::string(), header(0), measurement("7")})
    CHECK(has(refusal("p.dxf", drawing(content, head)), "the key unit of [[panel]]"));
}

TEST_CASE("DXF: what is wrong is named") {
  const auto says = [](const std::string& text, const std::string& part, const pattern::ReadOptions& o = {}) {
    const std::string message = refusal("p.dxf", text, o);
    INFO(message);
    CHECK(has(message, part));
  };
  says(drawing(line("a", {0, 0}, {100, 0}) + line("a", {100, 0}, {100, 100})), "the outline is open");
  says(drawing(polyline("a", square) + line("a", {0, 0}, {-100, 0})), "the outline is open");
  says(drawing(line("a", {0, 0}, {100, 0}) + line("a", {100, 0}, {100, 90}) + line("a", {100, 0}, {0, 90}) +
               line("a", {0, 0}, {0, 90})),
       "three curves or more meet near (100, 0)");
  says(drawing(""), "there is no outline");
  says(drawing(polyline("a", square)), "none of those there are: a", {.pieces = {"b"}});
  says("AutoCAD Binary DXF\r\n", "binary drawing");
  says("  0\nSECTION\nhello\n", "line 3: the number of a group");
  says("  0\nSECTION\n  2", "ends within a group");
  says(drawing(entity("LINE", "a", pairs(10, {{0, 0}}))), "groups 11 and 21 are missing");
  says(drawing(entity("ARC", "a", pairs(10, {{0, 0}}) + groups({{40, "1e999"}}))), "finite number, not '1e999'");
  says(drawing(entity("SPLINE", "a", groups({{71, "9"}}))), "its degree is 9");
  says(blocks(block("B", polyline("1", square) + polyline("1", {{300, 0}, {400, 0}, {400, 100}}))), "has 2 outlines");
  says(blocks(block("B", polyline("1", square)) + block("B", polyline("1", square))), "another piece has this name");
}

TEST_CASE("DXF: blocks that are placed are passed over and named; in another size they are refused") {
  const std::string placed = entity("INSERT", "0", groups({{2, "SLEEVE"}})),
                    larger = entity("INSERT", "0", groups({{2, "SLEEVE"}, {41, "2"}, {42, "2"}}));
  CHECK(has(refusal("p.dxf", drawing(placed)), "explode SLEEVE"));
  const pattern::Pattern other = read("p.dxf", drawing(polyline("front", square) + placed + placed));
  REQUIRE(other.notes.size() == 1);
  CHECK(has(other.notes[0], "explode SLEEVE if"));
  CHECK(has(refusal("p.dxf", drawing(polyline("front", square) + larger)), "places block 'SLEEVE' 2 times as large"));
  const std::string own = section("BLOCKS", block("SLEEVE", polyline("1", square)));
  CHECK(read("p.dxf", drawing(placed, header(4) + own)).notes.empty());
  const std::string turned = entity("INSERT", "0", groups({{2, "SLEEVE"}, {41, "-1"}}));
  for (const std::string& times : {turned, placed + placed, placed + turned}) {
    const pattern::Pattern once = read("p.dxf", drawing(times, header(4) + own));
    CHECK(once.pieces.size() == 1);
    REQUIRE(once.notes.size() == 1);
    CHECK(has(once.notes[0], "piece 'SLEEVE' (placed"));
  }
  const std::string pair = block("SLEEVE", polyline("1", square) + entity("TEXT", "1", groups({{1, "Quantity: 2"}})) +
                                               entity("TEXT", "1", groups({{1, "Units: ENGLISH"}})));
  const pattern::Pattern cut = read("p.dxf", drawing(placed, header(4) + section("BLOCKS", pair)));
  REQUIRE(cut.notes.size() == 2);
  CHECK(has(cut.notes[0], "contradicts $INSUNITS"));
  CHECK(has(cut.notes[1], "(quantity 2) is read once"));
}

TEST_CASE("Halves of other formats unfold across an edge that is named") {
  const std::string svg =
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="1000mm" height="1000mm" viewBox="0 0 1000 1000">)"
      R"(<path id="P" d="M0 0 L0 200 L100 200 Q 160 100 100 0 Z"/></svg>)";
  const pattern::Piece p = read("half.svg", svg, {.unfold = "0"}).pieces.at(0);
  CHECK(p.edges.size() == 6);
  CHECK(std::abs(std::abs(p.signed_area()) - 2.0 * (0.02 + 2.0 / 3.0 * 0.2 * 0.03)) < 1e-9);
  CHECK((p.point(0) - Vec2(0.0, -0.2)).norm() < 1e-12);
  CHECK(has(refusal("half.svg", svg, {.unfold = "2"}), "edge 2 is bent"));
  CHECK(has(refusal("half.svg", svg, {.unfold = "7"}), "unfold = \"7\""));
}

}  // namespace test_dxf

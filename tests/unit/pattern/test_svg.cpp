#include <doctest/doctest.h>

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "test_pattern_kit.hpp"

namespace test_svg {

using namespace voile;
using namespace voile::testing;

namespace {

const std::string millimetres = R"(width="1000mm" height="1000mm" viewBox="0 0 1000 1000")";

std::string svg(const std::string& content, const std::string& head = millimetres) {
  return fmt::format("<?xml version=\"1.0\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" {}>{}</svg>\n", head, content);
}

std::string path(const std::string& d, const std::string& more = "") {
  return fmt::format(R"(<path id="P" d="{}" {}/>)", d, more);
}

pattern::Piece piece(const std::string& content, const std::string& head = millimetres,
                     const pattern::ReadOptions& o = {}) {
  return read("pattern.svg", svg(content, head), o).pieces.at(0);
}

}  // namespace

TEST_CASE("SVG: the same square in many words") {
  for (const std::string& content :
       {path("M100,100 L 300 100 300,300 L100 300 Z"), path("m100 100h200v200h-200z"),
        path("M100 100 H300 V300 H100 V100"), path("M100-100l2e2 0 0-200-200 0z"),
        std::string(R"(<polygon id="P" points="100,100 300,100 300,300 100,300"/>)"),
        std::string(R"(<polyline id="P" points="100 100 300 100 300 300 100 300 100 100"/>)"),
        std::string(R"(<rect id="P" x="100" y="100" width="200" height="200"/>)"),
        std::string(R"x(<g id="P" transform="translate(5,6) scale(2)">)x"
                    R"x(<rect width="100" height="100" transform="rotate(30)"/></g>)x"),
        std::string(R"x(<g transform="matrix(0 1 -1 0 7 8)">)x"
                    R"x(<polygon id="P" points="0,0 200,0 200,200 0,200"/></g>)x")}) {
    INFO(content);
    const pattern::Piece p = piece(content);
    CHECK(p.name == "P");
    CHECK(p.edges.size() == 4);
    CHECK(std::abs(p.signed_area()) == doctest::Approx(0.04).epsilon(1e-12));
    for (const pattern::Edge& e : p.edges) CHECK(e.curve.length() == doctest::Approx(0.2).epsilon(1e-12));
  }
  // y points down in the file, up in the piece.
  CHECK(piece(path("M100,100 L 300 100 300,200 Z")).point(2)[1] == doctest::Approx(-0.2));
}

TEST_CASE("SVG: curves to 1e-9 against closed forms") {
  const auto area = [](const std::string& d) { return std::abs(piece(path(d)).signed_area()); };
  // Parabolas over a chord of 200 mm, height of the control point 60 mm, on a square.
  CHECK(std::abs(area("M0 0 Q 100 -60 200 0 V200 H0 Z") - (0.04 + 2.0 / 3.0 * 0.5 * 0.2 * 0.06)) < 1e-9);
  CHECK(std::abs(area("M0 0 q 50 -60 100 0 t 100 0 V200 H0 Z") - 0.04) < 1e-9);  // up and down
  CHECK(std::abs(area("M0 0 C 66.66666666666667 -60 133.33333333333334 -60 200 0 V200 H0 Z") -
                 (0.04 + 0.5 * 0.2 * 0.06)) < 1e-9);
  CHECK(
      std::abs(area("M0 0 C 33.33333333333333 -60 66.66666666666667 -60 100 0 S 166.6666666666667 60 200 0 V200 H0 Z") -
               0.04) < 1e-9);
  // Half a circle and half an ellipse, turned; flags without spaces.
  const double half = 0.5 * std::numbers::pi;
  CHECK(std::abs(area("M0 0 A100 100 0 01200 0 V200 H0 Z") - (0.04 + half * 0.01)) < 1e-9);
  CHECK(std::abs(area("M0 0 a100,50 0 0 1 200 0 V200 H0 Z") - (0.04 + half * 0.1 * 0.05)) < 1e-9);
  const pattern::Piece full = piece(path("M0 0 a100,50 30 0 1 40 0 a100,50 30 1 1 -40 0 Z"));
  CHECK(std::abs(std::abs(full.signed_area()) - std::numbers::pi * 0.1 * 0.05) < 1e-9);
  // A radius that does not reach is made larger.
  CHECK(std::abs(area("M0 0 A10 10 0 0 1 200 0 V200 H0 Z") - (0.04 + half * 0.01)) < 1e-9);
}

TEST_CASE("SVG: further loops of a path are holes, whatever their sense and order") {
  constexpr double pi = std::numbers::pi;
  // In a square of 200 mm a circle of 30 mm, an ellipse of 10 and 20 mm, and a square with one side a parabola 6 mm high.
  const std::string square = "M0 0 H200 V200 H0 Z", circle = "M30 60 a30 30 0 0 1 60 0 a30 30 0 0 1 -60 0 Z",
                    ellipse = "M120 50 a10 20 0 0 0 20 0 a10 20 0 0 0 -20 0 Z",
                    arched = "m100 100 q 20 -12 40 0 v40 h-40 z";
  const double wanted = 0.04 - pi * 9e-4 - pi * 2e-4 - (0.0016 + 2.0 / 3.0 * 0.04 * 0.006);
  for (const std::string& d : {square + circle + ellipse + "M0 0" + arched, circle + "M0 0" + arched + square + ellipse,
                               "M0 0 V200 H200 V0 Z" + circle + ellipse + "M0 0" + arched}) {
    INFO(d);
    const pattern::Piece p = piece(path(d));
    CHECK(p.loops().size() == 4);
    CHECK(std::abs(std::abs(p.signed_area()) - wanted) < 1e-9);
    CHECK(p.edges.size() == 12);
    double around = 0.0;
    for (const pattern::Edge& e : p.edges) around += e.curve.length();
    // Of the parabola y = 4 h x (w - x) / w^2 with c = 4 h / w: w/2 (sqrt(1 + c^2) + asinh(c) / c).
    const double c = 0.6, parabola = 0.02 * (std::hypot(1.0, c) + std::asinh(c) / c);
    const double a = 0.02, e2 = 0.75;  // of the ellipse: 4 a E(e)
    CHECK(std::abs(around - (0.8 + 0.06 * pi + 4.0 * a * std::comp_ellint_2(std::sqrt(e2)) + 0.12 + parabola)) < 1e-9);
  }
  // Edges count in the order of the file, from each loop's first point on and round it.
  const pattern::Piece p = piece(path(circle + square));
  CHECK(p.outline() == 1);
  CHECK(!p.is_in_outline(1));
  CHECK(p.is_in_outline(2));
  CHECK(p.next(1) == 0);
  CHECK(p.next(5) == 2);
  CHECK((p.point(0) - Vec2(0.03, -0.06)).norm() < 1e-12);
  CHECK((p.point(3) - Vec2(0.2, 0.0)).norm() < 1e-12);
}

TEST_CASE("SVG: halves with holes unfold; a hole that begins at the fold becomes one") {
  const std::string half = "M0 0 V200 H100 V0 Z";
  const pattern::Piece twice = piece(path(half + "M20 20 H60 V80 Z"), millimetres, {.unfold = "0"});
  CHECK(twice.loops().size() == 3);
  CHECK(twice.edges.size() == 12);
  CHECK(std::abs(std::abs(twice.signed_area()) - (0.04 - 2.0 * 0.5 * 0.04 * 0.06)) < 1e-12);
  CHECK((twice.point(6) - Vec2(0.02, -0.02)).norm() < 1e-12);
  CHECK((twice.point(9) - Vec2(-0.02, -0.02)).norm() < 1e-12);
  const pattern::Piece once = piece(path(half + "M0 50 V90 H30 V50 Z"), millimetres, {.unfold = "0"});
  CHECK(once.loops().size() == 2);
  CHECK(once.edges.size() == 12);
  CHECK(std::abs(std::abs(once.signed_area()) - (0.04 - 0.06 * 0.04)) < 1e-12);
  const auto says = [](const std::string& d, const std::string& edge, const char* part) {
    const std::string message = refusal("pattern.svg", svg(path(d)), {.unfold = edge});
    INFO(message);
    CHECK(has(message, part));
  };
  says(half + "M20 20 H60 V80 H20 Z", "7", "edge 7 belongs to a hole");
  says(half + "M0 50 L30 50 L30 90 Z", "0", "cross or touch near (0, -0.05)");  // a corner on the fold
}

TEST_CASE("SVG: the unit is stated or asked for") {
  const std::string content = path("M0 0 H100 V100 H0 Z");
  const auto side = [&](const std::string& head, const pattern::ReadOptions& o = {}) {
    return piece(content, head, o).edges[0].curve.length();
  };
  CHECK(side(R"(width="50cm" height="50cm" viewBox="0 0 1000 1000")") == doctest::Approx(0.05));
  CHECK(side(R"(width="10in" viewBox="0 0 100 100")") == doctest::Approx(0.254));
  CHECK(side("", {.unit = 0.01}) == doctest::Approx(1.0));
  for (const std::string& head :
       {std::string(""), std::string(R"(width="1000" height="1000" viewBox="0 0 1000 1000")"),
        std::string(R"(width="1000px" viewBox="0 0 1000 1000")"), std::string(R"(width="1m")"),
        std::string(R"(width="1m" height="2m" viewBox="0 0 10 10")")}) {
    INFO(head);
    const std::string message = refusal("pattern.svg", svg(content, head));
    CHECK(has(message, "the key unit of [[panel]]"));
  }
  CHECK(has(refusal("pattern.svg", svg(content), {.unit = 1.0}), "100 m x 100 m"));  // millimetres taken for metres
}

TEST_CASE("SVG: lengths with units, and what is hidden or drawn in another size") {
  const auto square = [](const std::string& more) { return R"(<rect id="P" width="100" height="100" )" + more + "/>"; };
  // An inch is 96 user units, whatever one is in the drawing.
  const pattern::Piece p = piece(R"(<rect id="P" x="1in" width="2in" height="12.7mm"/>)",
                                 R"(width="40in" height="30in" viewBox="0 0 3840 2880")");
  CHECK(p.edges[0].curve.length() == doctest::Approx(0.0508).epsilon(1e-12));
  CHECK(p.edges[1].curve.length() == doctest::Approx(0.0127).epsilon(1e-12));
  CHECK(p.point(0)[0] == doctest::Approx(0.0254).epsilon(1e-12));
  const pattern::Pattern shown =
      read("pattern.svg", svg(R"(<g id="guides" style="fill:red; display : none">)" + path("M0 0 H50 V50 Z") +
                              R"(</g><g display="none">)" + path("M0 0 H50 V50 Z") + "</g>" + square("")));
  CHECK(shown.pieces.size() == 1);
  REQUIRE(shown.notes.size() == 2);
  CHECK(has(shown.notes[0], "'guides' is hidden"));
  const std::string triangle = R"(<path d="M0 0 H50 V50 Z" id=)";
  const pattern::Pattern styled =
      read("pattern.svg",
           svg("<defs><style>/* .P{display:none} */ .a, .b { fill:red; display : none; } .c{fill:red}</style></defs>" +
               triangle + R"("Q" class="c b"/>)" + triangle + R"("R" visibility="hidden"/>)" + triangle +
               R"("S" style="visibility: collapse"/>)" + square(R"(class="P c")")));
  CHECK(styled.pieces.size() == 1);
  CHECK(styled.notes.size() == 3);
  const auto says = [](const std::string& content, const char* part) {
    const std::string message = refusal("pattern.svg", svg(content));
    INFO(message);
    CHECK(has(message, part));
  };
  says("<style>path.a > rect{display:none}</style>" + square(""), "hides what 'path.a>rect' selects");
  says(R"(<rect id="P" width="50%" height="5"/>)", "width = '50%' is no length");
  says(square(R"x(style="fill:none;transform:scale(2)")x"), "make it the attribute transform");
  says(R"(<svg width="50" height="50" viewBox="0 0 10 10">)" + square("") + "</svg>", "a drawing within the drawing");
  says(R"(<svg x="5">)" + square("") + "</svg>", "a drawing within the drawing");
  CHECK(piece("<svg>" + square(R"(style="text-transform:none")") + "</svg>").edges.size() == 4);
}

TEST_CASE("SVG: what is wrong is named with piece, edge and remedy") {
  const auto says = [](const std::string& content, std::initializer_list<const char*> parts) {
    const std::string message = refusal("pattern.svg", svg(content));
    INFO(message);
    for (const char* part : parts) CHECK(has(message, part));
  };
  says("", {"no outline"});
  says(path("M0 0 H100 V100"), {"'P'", "open", "after edge 1", "command Z"});
  says(path("M0 0 L100 100 L100 0 L0 100 Z"), {"'P'", "edges 0 and 2", "figure of eight"});
  says(path("M0 0 C 300 200 -200 200 100 0 Z"), {"'P'", "edge 0", "crosses itself"});
  says(path("M0 0 H100 V100 Z L5 5"), {"'P'", "after a loop is closed"});
  // Holes outside, across, touching at a corner of either, on each other, within each other, open, folded, all around.
  const std::string square = "M0 0 H100 V100 H0 Z ";
  says(path(square + "M110 10 h9 v9 Z"), {"'P'", "edges 4 to 6", "outside of the outline", "pieces of their own"});
  says(path(square + "M90 10 h30 v9 Z"), {"'P'", "edges 1 and 4", "the hole (edges 4 to 6)", "move the hole"});
  says(path(square + "M50 100 L60 80 L40 80 Z"), {"'P'", "near (0.05, -0.1) m", "must be clear of each other"});
  says(path(square + "M0 0 L60 80 L40 80 Z"), {"'P'", "the outline (edges 0 to 3)", "near (0, 0) m"});
  says(path(square + "M10 10 h40 v40 Z M30 10 h40 v40 Z"), {"the hole (edges 4 to 6)", "the hole (edges 7 to 9)"});
  says(path(square + "M10 10 h40 v40 h-40 Z M20 20 h9 v9 Z"), {"edges 8 to 10", "inside of the hole (edges 4 to 7)"});
  says(path(square + "M20 20 h9 v9"), {"'P'", "open", "after edge 5"});
  says(path(square + "M20 20 h30 l-30 10 h30 Z"), {"'P'", "edges 5 and 7", "a hole goes round once"});
  says(path(square + "M20 20 c 40 40 -40 40 0 0 Z"), {"'P'", "the hole (edges 4 to 4) has at least two edges"});
  says(path(square + square), {"'P'", "cross or touch"});
  says(path("M0 0 H100 Vx"), {"'P'", "a number is expected"});
  says(path("M0 0 H100 B3"), {"'P'", "unknown command 'B'"});
  says(path("M0 0 A5 5 0 2 1 9 9"), {"'P'", "flag"});
  says(path(""), {"'P'", "draws nothing"});
  says(path("M0 0 H100 V100 H50 V0 Z"), {"'P'", "cross or touch"});
  says(path("M0 0 H100 V100 Z", R"x(transform="scale(0)")x"), {"'P'", "no area"});
  says(path("M0 0 H100 V100 Z", R"x(transform="blow(2)")x"), {"'P'", "'blow'"});
  says(path("M0 0 H100 V100 Z") + path("M0 0 H100 V100 Z"), {"'P'", "another piece"});
  says(R"(<path d="M0 0 H100 V100 Z"/>)", {"no name"});
  says(R"(<polyline id="P" points="0,0 9,0 9,9"/>)", {"'P'", "open"});
  says(R"(<rect id="P" width="5" height="5" rx="1"/>)", {"'P'", "round"});
  CHECK(has(refusal("pattern.svg", "<svg"), "not valid XML"));
  CHECK(has(refusal("pattern.svg", "<html/>"), "no <svg>"));
  CHECK(has(refusal("pattern.dwg", "0"), "unknown kind of pattern '.dwg'"));
  CHECK(piece(R"(<defs><path id="Q" d="M0 0"/></defs>)" + path("M0 0 H100 V100 Z")).name == "P");
}

}  // namespace test_svg

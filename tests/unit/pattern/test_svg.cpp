#include <doctest/doctest.h>

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "test_pattern_kit.hpp"

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
  says(path("M0 0 H100 V100 Z M10 10 H20 V20 Z"), {"'P'", "more than one outline"});
  says(path("M0 0 H100 V100 Z L5 5"), {"'P'", "after the outline is closed"});
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

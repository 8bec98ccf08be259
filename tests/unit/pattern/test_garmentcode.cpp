#include <doctest/doctest.h>

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "extent.hpp"
#include "test_pattern_kit.hpp"

namespace test_garmentcode {

using namespace voile;
using namespace voile::testing;

namespace {

/// One panel "P" with these edges on a square of 100 units; `rest`: further keys of the file.
std::string file(const std::string& edges, const std::string& rotation = "[0, 0, 0]", const std::string& rest = "",
                 const std::string& stitches = "[]") {
  return fmt::format(R"({{"pattern": {{"panels": {{"P": {{"translation": [0, 100, 25], "rotation": {},
    "vertices": [[0, 0], [100, 0], [100, 100], [0, 100]], "edges": [{}]}}}}, "stitches": {}}} {}}})",
                     rotation, edges, stitches, rest);
}

const std::string line1 = R"({"endpoints": [1, 2]})", line2 = R"({"endpoints": [2, 3]})",
                  line3 = R"({"endpoints": [3, 0]})",
                  square = R"({"endpoints": [0, 1], "label": "hem"}, )" + line1 + ", " + line2 + ", " + line3;

std::string curved(const std::string& curvature) {
  return fmt::format(R"({{"endpoints": [0, 1], "curvature": {}}}, {}, {}, {})", curvature, line1, line2, line3);
}

pattern::Piece piece(const std::string& text, const pattern::ReadOptions& o = {}) {
  return read("pattern.json", text, o).pieces.at(0);
}

}  // namespace

TEST_CASE("GarmentCode: lines, units, place") {
  const pattern::Piece p = piece(file(square));
  CHECK(p.signed_area() == doctest::Approx(1.0).epsilon(1e-12));  // centimetres
  CHECK(p.translation == Vec3(0, 1, 0.25));
  CHECK(p.edges[0].label == "hem");
  CHECK(!p.turned);
  CHECK(piece(file(square, "[0, 0, 0]", R"(, "properties": {"units_in_meter": 1000})")).signed_area() ==
        doctest::Approx(0.01).epsilon(1e-12));
  CHECK(piece(file(square), {.unit = 0.02}).translation[1] == doctest::Approx(2.0));
  const std::string clockwise =
      R"({"endpoints": [0, 3]}, {"endpoints": [3, 2]}, {"endpoints": [2, 1]}, {"endpoints": [1, 0]})";
  CHECK(piece(file(clockwise)).turned);
}

TEST_CASE("GarmentCode: edges that begin anew after a closed loop are holes") {
  const auto pattern_of = [](const std::string& edges) {
    return fmt::format(R"({{"pattern": {{"panels": {{"P": {{"translation": [0, 0, 0], "rotation": [0, 0, 0], "vertices":
      [[0, 0], [100, 0], [100, 100], [0, 100], [40, 40], [60, 40], [50, 70]], "edges": [{}]}}}}}}}})",
                       edges);
  };
  const auto loop = [](const std::vector<int>& points) {
    std::string text;
    for (std::size_t k = 0; k < points.size(); ++k)
      text +=
          fmt::format(R"({}{{"endpoints": [{}, {}]}})", k > 0 ? ", " : "", points[k], points[(k + 1) % points.size()]);
    return text;
  };
  const std::string outline = loop({0, 1, 2, 3}), hole = loop({4, 5, 6}), back = loop({0, 3, 2, 1});
  const pattern::Piece p = piece(pattern_of(outline + ", " + hole));
  CHECK(std::abs(p.signed_area() - (1.0 - 0.5 * 0.2 * 0.3)) < 1e-12);
  CHECK(!p.turned);
  const pattern::Piece q = piece(pattern_of(hole + ", " + back));  // the hole goes one way, the outline the other
  CHECK(std::abs(q.signed_area() + (1.0 - 0.5 * 0.2 * 0.3)) < 1e-12);
  CHECK(q.turned);
  CHECK(!q.is_in_outline(0));
  CHECK(q.is_in_outline(3));
  const std::string open = R"(, {"endpoints": [4, 5]}, {"endpoints": [5, 6]})";
  CHECK(has(refusal("p.json", pattern_of(outline + open)), "edge 5 ends at vertex 6, but edge 4 starts at vertex 4"));
  CHECK(has(refusal("p.json", pattern_of(outline + R"(, {"endpoints": [4, 5]}, {"endpoints": [6, 4]})")),
            "it starts at vertex 6, but edge 4 before it ends at vertex 5"));
  CHECK(has(refusal("p.json", pattern_of("")), "there are no edges"));
}

TEST_CASE("GarmentCode: every curve to 1e-9 against closed forms") {
  // On an edge of 1 m; control points in terms of the edge and what is square to it, positive into the square.
  const auto area = [](const std::string& c) { return piece(file(curved(c))).signed_area(); };
  CHECK(std::abs(area(R"({"type": "quadratic", "params": [[0.5, 0.3]]})") - (1.0 - 2.0 / 3.0 * 0.5 * 0.3)) < 1e-9);
  CHECK(area("[0.5, 0.3]") == area(R"({"type": "quadratic", "params": [[0.5, 0.3]]})"));
  // Between chord and a cubic with control points (1/3, h), (2/3, h): 1/2 of h.
  CHECK(std::abs(area(R"({"type": "cubic", "params": [[0.3333333333333333, 0.2], [0.6666666666666666, 0.2]]})") -
                 (1.0 - 0.5 * 0.2)) < 1e-9);
  const std::string absolute = R"(, "properties": {"curvature_coords": "absolute"})";
  CHECK(std::abs(piece(file(curved("[50, 30]"), "[0, 0, 0]", absolute)).signed_area() - 0.9) < 1e-9);
  // Circles of radius 80 units: segment of angle 2 asin(0.5/0.8).
  const double r = 0.8, angle = 2.0 * std::asin(0.5 / r), segment = 0.5 * r * r * (angle - std::sin(angle));
  for (const int large : {0, 1})
    for (const int right : {0, 1}) {
      const pattern::Piece p =
          piece(file(curved(fmt::format(R"({{"type": "circle", "params": [80, {}, {}]}})", large, right)), "[0, 0, 0]",
                     R"(, "properties": {"units_in_meter": 100})"));
      const double bulge = large ? std::numbers::pi * r * r - segment : segment;
      CHECK(std::abs(p.signed_area() - (1.0 + (right ? bulge : -bulge))) < 1e-9);
      CHECK(std::abs(p.edges[0].curve.length() - r * (large ? 2.0 * std::numbers::pi - angle : angle)) < 1e-9);
    }
}

TEST_CASE("GarmentCode: both orders of rotation, and a remark where they differ") {
  const pattern::Pattern both = read("pattern.json", file(square, "[90, 45, 0]"));
  const Vec3 ex = both.pieces[0].rotation.col(0), ey = both.pieces[0].rotation.col(1);
  const double s = std::sqrt(0.5);
  CHECK((ex - Vec3(s, 0, -s)).norm() < 1e-12);  // Ry(45) ex
  CHECK((ey - Vec3(s, 0, s)).norm() < 1e-12);   // Ry(45) Rx(90) ey = Ry(45) ez
  REQUIRE(both.notes.size() == 1);
  CHECK(has(both.notes[0], "panel 'P'"));
  CHECK(has(both.notes[0], "euler"));
  const pattern::Pattern other = read("pattern.json", file(square, "[90, 45, 0]"), {.euler_xyz = true});
  CHECK((other.pieces[0].rotation.col(0) - Vec3(s, s, 0)).norm() < 1e-12);  // Rx(90) Ry(45) ex
  CHECK(read("pattern.json", file(square, "[0, 45, 0]")).notes.empty());
}

TEST_CASE("GarmentCode: what is wrong is named with panel, edge and remedy") {
  const auto says = [](const std::string& text, std::initializer_list<const char*> parts) {
    const std::string message = refusal("pattern.json", text);
    INFO(message);
    CHECK(has(message, "pattern.json"));
    for (const char* part : parts) CHECK(has(message, part));
  };
  says("", {"the file is empty"});
  says("{\"pattern\": {", {"not valid JSON", "byte"});
  says("[1, 2]", {"a table"});
  says("{}", {"'pattern' is missing"});
  says(R"({"pattern": {"panels": {}}})", {"no panels"});
  says(file(R"({"endpoints": [0, 1]}, )" + line2 + ", " + line3), {"'P'", "edge 1", "open", "vertex 1"});
  says(file(R"({"endpoints": [0, 1]}, )" + line1 + ", " + line2), {"'P'", "open", "edge 2 ends at vertex 3"});
  says(file(R"({"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [3, 2]}, {"endpoints": [3, 0]})"),
       {"'P'", "edge 2", "runs backwards", "exchange its endpoints"});
  says(file(R"({"endpoints": [0, 7]})"), {"'P'", "edge 0", "no vertex 7"});
  says(file(R"({"endpoints": [0, 0]}, )" + line1), {"edge 0", "same place"});
  says(file(R"({"endpoints": [0, 2]}, {"endpoints": [2, 1]}, {"endpoints": [1, 3]}, {"endpoints": [3, 0]})"),
       {"'P'", "edges 0 and 2", "figure of eight"});
  says(file(curved(R"({"type": "circle", "params": [40, 0, 1]})")), {"edge 0", "radius 0.4", "at least half"});
  says(file(curved(R"({"type": "spiral", "params": []})")), {"edge 0", "'spiral'"});
  says(file(curved(R"({"type": "cubic", "params": [[0.5, 0.1]]})")), {"edge 0", "at least 2"});
  says(file(square, "[0, 0]"), {"'P'", "rotation", "3 numbers"});
  says(file(square, "[0, 0, 0]", "", R"([[{"panel": "Q", "edge": 0}, {"panel": "P", "edge": 1}]])"),
       {"stitch 0", "no panel 'Q'"});
  says(file(square, "[0, 0, 0]", "", R"([[{"panel": "P", "edge": 0}, {"panel": "P", "edge": 9}]])"),
       {"stitch 0", "no edge 9"});
  says(file(square, "[0, 0, 0]", R"(, "properties": {"units_in_meter": 1})"), {"'P'", "100 m x 100 m", "unit"});
  CHECK(has(refusal("pattern.json", file(square), {.pieces = {"Q"}}), "no piece 'Q'"));
}

TEST_CASE("GarmentCode: old files leave open which ends of a stitch meet") {
  const std::string stitch = R"([[{"panel": "P", "edge": 1}, {"panel": "P", "edge": 3}]])";
  CHECK(read("pattern.json", file(square, "[0, 0, 0]", "", stitch)).stitches.at(0).sense == pattern::Sense::against);
  CHECK(read("pattern.json", file(curved("[0.5, 0.1]"), "[0, 0, 0]", "", stitch)).stitches.at(0).sense ==
        pattern::Sense::nearest);
  const std::string wrong = R"([[{"panel": "P", "edge": 1}, {"panel": "P", "edge": 3}, "right_wrong"]])";
  CHECK(read("pattern.json", file(square, "[0, 0, 0]", "", wrong)).stitches.at(0).sense == pattern::Sense::along);
}

TEST_CASE("damaged patterns are refused or read, but nothing crashes") {
  const std::string json =
      file(curved(R"({"type": "circle", "params": [80, 0, 1]})"), "[90, 45, 0]",
           R"(, "properties": {"units_in_meter": 100})", R"([[{"panel": "P", "edge": 1}, {"panel": "P", "edge": 3}]])");
  const std::string svg =
      R"x(<svg width="1m" height="1m" viewBox="0 0 1000 1000"><g transform="rotate(30) scale(1 2)"><path id="P" )x"
      R"x(d="M0 0 C 60 -60 130 -60 200 0 a100,50 30 0 1 40 0 V200 q 5 5 -50 0 T0 200Z"/></g></svg>)x";
  const std::string bytes = "0123456789-+.eE,[]{}\"'<>/ZzMmAaCcNn \n";
  unsigned state = 12345;
  const auto random = [&](std::size_t end) { return (state = state * 1664525u + 1013904223u) / 65536u % end; };
  int refused = 0;
  for (int k = 0; k < extent(300, 60); ++k) {
    std::string text = k % 2 ? json : svg;
    for (std::size_t i = 0; i <= random(4); ++i) {
      const std::size_t at = random(text.size());
      if (random(3) == 0)
        text.erase(at, random(20));
      else
        text[at] = bytes[random(bytes.size())];
    }
    refused += refusal(k % 2 ? "damaged.json" : "damaged.svg", text).empty() ? 0 : 1;
  }
  CHECK(refused > extent(100, 20));
  std::string deep;
  for (int k = 0; k < 200000; ++k) deep += "<g>";
  (void)refusal("deep.svg", R"(<svg width="1m" viewBox="0 0 9 9">)" + deep);
  CHECK(has(refusal("huge.json", R"({"pattern": 1e999})"), "not valid JSON"));
}

}  // namespace test_garmentcode

// Pieces from the texture coordinates of OBJ files, and the seams between them.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "test_pattern_kit.hpp"
#include "test_relative.hpp"

namespace test_obj {

using namespace voile;
using namespace voile::testing;
using pattern::Sense;

namespace {

using ToSpace = std::function<Vec3(const Vec2&)>;

/// An OBJ file that grows grid by grid.
class Obj {
 public:
  /// Cells of a rectangle from (x, y) on, `unit` being the length of 1 in vt [m]. Returns its first vertex, counted from 0;
  /// rows of i go first.
  long grid(const std::string& name, const Vec2& from, const Vec2& size, int nx, int ny, const ToSpace& place,
            double unit = 1.0) {
    const long first = vertices_;
    text_ += "g " + name + "\n";
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) {
        const Vec2 u(from[0] + size[0] * i / nx, from[1] + size[1] * j / ny);
        const Vec3 x = place(u);
        text_ += fmt::format("v {:.9g} {:.9g} {:.9g}\nvt {:.9g} {:.9g}\n", x[0], x[1], x[2], u[0] / unit, u[1] / unit);
      }
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const long a = first + 1 + j * (nx + 1) + i, b = a + 1, c = b + nx + 1, d = a + nx + 1;
        face({a, b, c});
        face({a, c, d});
      }
    vertices_ += (nx + 1) * (ny + 1);
    return first;
  }
  void face(const std::vector<long>& corners) {
    text_ += "f";
    for (const long v : corners) text_ += fmt::format(" {}/{}", v, v);
    text_ += "\n";
  }
  void stitch(long a, long b, long c, double t) { text_ += fmt::format("stitch {} {} {} {:.9g}\n", a, b, c, t); }
  void add(const std::string& text) { text_ += text; }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
  long vertices_ = 0;
};

Vec3 lying(const Vec2& u) {
  return {u[0], u[1], 0.0};
}

/// Two rectangles of 0.4 x 0.6 m in space one behind the other, at the same place in vt; 6 and `cells` cells high.
Obj two_sheets(int cells, long& front, long& back) {
  Obj obj;
  front = obj.grid("front", {0, 0}, {0.4, 0.6}, 4, 6, lying);
  back = obj.grid("back", {0, 0}, {0.4, 0.6}, 4, cells, [](const Vec2& u) { return Vec3(u[0], u[1], 0.2); });
  return obj;
}

}  // namespace

TEST_CASE("OBJ pattern: lines 'stitch' between vertices and inside of edges become seams from corner to corner") {
  for (const int cells : {6, 4, 9}) {
    CAPTURE(cells);
    long front = 0, back = 0;
    Obj obj = two_sheets(cells, front, back);
    // The right edge of the front, vertex by vertex, to that of the back, wherever that is.
    for (int j = 0; j <= 6; ++j) {
      const double at = j * cells / 6.0;
      const int low = std::min(static_cast<int>(at), cells - 1);
      obj.stitch(front + 5 * j + 4, back + 5 * low + 4, back + 5 * (low + 1) + 4, at - low);
    }
    const pattern::Pattern p = read("pattern.obj", obj.text());
    REQUIRE(p.pieces.size() == 2);
    CHECK(p.pieces[0].name == "front");
    CHECK(p.pieces[1].name == "back");
    for (const pattern::Piece& piece : p.pieces) {
      CHECK(piece.edges.size() == 4);
      CHECK(piece.signed_area() == relative(0.24).epsilon(1e-8));
      CHECK_FALSE(piece.turned);
      CHECK_FALSE(piece.bent);
    }
    CHECK(p.pieces[1].translation[2] == relative(0.2).epsilon(1e-8));
    REQUIRE(p.stitches.size() == 1);
    const pattern::Stitch& s = p.stitches[0];
    CHECK(s.sense == Sense::along);  // both run upwards on their right
    CHECK(s.sides[0].edge == s.sides[1].edge);
    const pattern::Curve& c = p.pieces[0].edges[s.sides[0].edge].curve;
    CHECK(c.is_line());
    CHECK(c.length() == relative(0.6).epsilon(1e-8));
    CHECK(c.start()[0] == relative(0.4).epsilon(1e-8));
  }
}

TEST_CASE("OBJ pattern: a seam that ends amid an edge divides it, and the rest stays open") {
  long front = 0, back = 0;
  Obj obj = two_sheets(6, front, back);
  for (int j = 0; j <= 3; ++j) obj.stitch(front + 5 * j + 4, back + 5 * j + 4, back + 5 * j + 4, 0.0);
  const pattern::Pattern p = read("pattern.obj", obj.text());
  REQUIRE(p.stitches.size() == 1);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK(p.pieces[k].edges.size() == 5);
    CHECK(p.pieces[k].edges[p.stitches[0].sides[k].edge].curve.length() == relative(0.3).epsilon(1e-8));
  }
}

TEST_CASE(
    "OBJ pattern: a T-seam takes part of an edge for each piece, though the last cell before their corner is not "
    "stitched") {
  // Below a wide sheet hang two of half its width; every vertex of the upper ones is stitched to one point, the corner to the left.
  Obj obj;
  const long top = obj.grid("top", {0, 0}, {0.8, 0.2}, 8, 2, lying);
  const long left =
      obj.grid("left", {2, 0}, {0.4, 0.4}, 4, 4, [](const Vec2& u) { return Vec3(u[0] - 2.0, u[1] - 0.5, 0); });
  const long right =
      obj.grid("right", {3, 0}, {0.4, 0.4}, 4, 4, [](const Vec2& u) { return Vec3(u[0] - 2.6, u[1] - 0.5, 0); });
  for (int i = 0; i <= 8; ++i) {
    const long other = i <= 4 ? left + 20 + i : right + 20 + i - 4;
    obj.stitch(top + i, other, other, 0.0);
  }
  const pattern::Pattern p = read("pattern.obj", obj.text());
  REQUIRE(p.pieces.size() == 3);
  CHECK(p.pieces[0].edges.size() == 5);
  REQUIRE(p.stitches.size() == 2);
  for (const pattern::Stitch& s : p.stitches) {
    CHECK(s.sense == Sense::against);
    CHECK(s.sides[0].piece == "top");
    for (const pattern::StitchEnd& e : s.sides)
      for (const pattern::Piece& piece : p.pieces)
        if (piece.name == e.piece) CHECK(piece.edges[e.edge].curve.length() == relative(0.4).epsilon(1e-8));
  }
}

TEST_CASE("OBJ pattern: vertices in common of a tube are a seam of the piece with itself, in millimetres of vt") {
  constexpr double radius = 0.1;
  const double girth = 2.0 * std::numbers::pi * radius;
  const int n = 24;
  std::string text;
  for (int j = 0; j <= 3; ++j)
    for (int i = 0; i < n; ++i)
      text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", radius * std::cos(2 * std::numbers::pi * i / n), 0.1 * j,
                          -radius * std::sin(2 * std::numbers::pi * i / n));
  for (int j = 0; j <= 3; ++j)
    for (int i = 0; i <= n; ++i) text += fmt::format("vt {:.9g} {:.9g}\n", 1000.0 * girth * i / n, 100.0 * j);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < n; ++i) {
      const auto corner = [&](int a, int b) { return fmt::format("{}/{}", b * n + a % n + 1, b * (n + 1) + a + 1); };
      text += fmt::format("f {} {} {} {}\n", corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
  const pattern::Pattern p = read("tube.obj", text);
  REQUIRE(p.pieces.size() == 1);
  CHECK(p.pieces[0].name == "piece");
  CHECK(p.pieces[0].signed_area() == relative(girth * 0.3).epsilon(1e-8));
  REQUIRE(p.pieces[0].bent);
  REQUIRE(p.stitches.size() == 1);
  CHECK(p.stitches[0].sense == Sense::against);
  // A point in the middle of a cell lies on the chord there.
  const Vec3 x = p.pieces[0].bent->at({girth * 0.5 / n, 0.05});
  CHECK(std::hypot(x[0], x[2]) == relative(radius * std::cos(std::numbers::pi / n)).epsilon(1e-7));
  CHECK(x[1] == relative(0.05).epsilon(1e-8));
}

TEST_CASE("OBJ pattern: both sides of a dart end in its tip, stitched or of vertices in common") {
  // A square whose upper edge has a notch from (0.4, 1) and (0.6, 1) down to (0.5, 0.5), in cells along it.
  for (const bool is_stitched : {true, false}) {
    CAPTURE(is_stitched);
    const std::vector<Vec2> rim{{0, 0},     {1, 0},       {1, 1},   {0.6, 1}, {0.55, 0.75},
                                {0.5, 0.5}, {0.45, 0.75}, {0.4, 1}, {0, 1}};
    std::string text;
    for (const Vec2& x : rim) text += fmt::format("vt {} {}\n", x[0], x[1]);
    // Space: the notch is closed if vertices are shared.
    for (const Vec2& x : rim) text += fmt::format("v {} {} 0\n", x[0], x[1]);
    const auto corner = [&](int k) {
      const int v = !is_stitched && k == 6 ? 4 : !is_stitched && k == 7 ? 3 : k;
      return fmt::format("{}/{}", v + 1, k + 1);
    };
    for (const auto& [a, b, c] :
         std::vector<std::array<int, 3>>{{0, 1, 5}, {1, 4, 5}, {1, 3, 4}, {1, 2, 3}, {0, 5, 6}, {0, 6, 7}, {0, 7, 8}})
      text += fmt::format("f {} {} {}\n", corner(a), corner(b), corner(c));
    if (is_stitched) text += "stitch 3 7 7 0\nstitch 4 6 6 0\n";
    pattern::ReadOptions options;
    options.texture_unit = 1.0;
    const pattern::Pattern p = read("dart.obj", text, options);
    REQUIRE(p.pieces.size() == 1);
    CHECK(p.pieces[0].edges.size() == 7);
    REQUIRE(p.stitches.size() == 1);
    const auto& [a, b] = p.stitches[0].sides;
    CHECK(p.stitches[0].sense == Sense::against);
    CHECK(p.pieces[0].edges[a.edge].curve.end() == p.pieces[0].edges[b.edge].curve.start());
    CHECK(p.pieces[0].edges[a.edge].curve.length() == relative(std::hypot(0.1, 0.5)).epsilon(1e-9));
    CHECK(p.pieces[0].point(b.edge) == Vec2(0.5, 0.5));
  }
}

TEST_CASE("OBJ pattern: round rims are sewn all round, wherever each begins") {
  // A disk of 16 corners and a ring round it whose inner rim begins elsewhere.
  const int n = 16;
  std::string text;
  const auto circle = [&](double radius, double z, double turn) {
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * (i + turn) / n;
      text += fmt::format("v {0:.9g} {1:.9g} {2}\nvt {0:.9g} {1:.9g}\n", radius * std::cos(angle),
                          radius * std::sin(angle), z);
    }
  };
  circle(0.1, 0.0, 0.0);        // 1 to 16: the disk
  text += "v 0 0 0\nvt 0 0\n";  // 17
  circle(0.1, 0.05, 5.5);       // 18 to 33: the inner rim of the ring
  circle(0.2, 0.05, 5.5);       // 34 to 49
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    text += fmt::format("f 17/17 {0}/{0} {1}/{1}\n", i + 1, j + 1);
    text += fmt::format("f {0}/{0} {1}/{1} {2}/{2} {3}/{3}\n", 18 + i, 34 + i, 34 + j, 18 + j);
    text += fmt::format("stitch {} {} {} 0.5\n", i, 17 + (i + n - 6) % n, 17 + (i + n - 5) % n);
  }
  const pattern::Pattern p = read("round.obj", text);
  REQUIRE(p.pieces.size() == 2);
  CHECK(p.pieces[1].loops().size() == 2);
  double sewn = 0.0, whole = 0.0;
  for (const pattern::Stitch& s : p.stitches) {
    CHECK(s.sense == Sense::against);  // the rim of a hole goes round the other way
    for (const pattern::Piece& piece : p.pieces)
      if (s.sides[0].piece == piece.name) sewn += piece.edges[s.sides[0].edge].curve.length();
  }
  for (const pattern::Edge& e : p.pieces[0].edges) whole += e.curve.length();
  CHECK(sewn == relative(whole).epsilon(1e-6));
  // It can be sewn: no edge twice.
  std::vector<pattern::Panel> panels(2);
  std::vector<pattern::SeamRequest> requests;
  for (std::size_t k = 0; k < 2; ++k) {
    panels[k].piece = p.pieces[k];
    panels[k].size = 0.02;
  }
  for (const pattern::Stitch& s : p.stitches) {
    pattern::SeamRequest r;
    r.where = fmt::format("stitch {}", s.number);
    for (std::size_t k = 0; k < 2; ++k)
      (k == 0 ? r.edges : r.to) = {fmt::format("{}/{}", s.sides[k].piece, s.sides[k].edge)};
    r.sense = s.sense;
    requests.push_back(r);
  }
  CHECK(pattern::make_garment(panels, requests).mesh.seams.size() == p.stitches.size());
}

TEST_CASE("OBJ pattern: a piece lies where its vertices are, turned anyhow, its right side where their normals point") {
  const Vec3 shift(0.3, -0.2, 1.0);
  for (int k = 0; k < 8; ++k) {
    const Mat3 turn = Eigen::AngleAxisd(0.7 + 0.8 * k, Vec3(1, 2 - k, 0.7 * k - 1).normalized()).toRotationMatrix();
    Obj turned;
    (void)turned.grid(
        "plain", {0.1, 0.2}, {0.3, 0.5}, 3, 5, [&](const Vec2& u) { return Vec3(turn * lying(u) + shift); }, 0.01);
    const pattern::Pattern p = read("turned.obj", turned.text());
    REQUIRE(p.pieces.size() == 1);
    CHECK_FALSE(p.pieces[0].bent);
    CHECK((p.pieces[0].rotation - turn).norm() < 1e-7);  // a reflection would put its points there, too
    CHECK((p.pieces[0].translation - shift).norm() < 1e-7);
  }
  Obj obj;
  // Drawn as seen from the wrong side: vt are mirrored, faces go round clockwise there.
  (void)obj.grid(
      "mirrored", {1, 0}, {0.3, 0.5}, 3, 5, [&](const Vec2& u) { return Vec3(-u[0], u[1], 2.0); }, 0.01);
  std::string text = obj.text();
  const pattern::Pattern p = read("mirrored.obj", text);
  REQUIRE(p.pieces.size() == 1);
  CHECK_FALSE(p.pieces[0].bent);
  CHECK_FALSE(p.pieces[0].turned);
  pattern::Panel panel;
  panel.piece = p.pieces[0];
  panel.size = 0.05;
  CHECK((panel.place({1.1, 0.2}) - Vec3(-1.1, 0.2, 2.0)).norm() < 1e-7);
  const pattern::Garment g = pattern::make_garment({panel}, {});
  const mesh::Triangle& t = g.mesh.triangles[0];
  const Vec3 normal =
      (g.mesh.positions[t[1]] - g.mesh.positions[t[0]]).cross(g.mesh.positions[t[2]] - g.mesh.positions[t[0]]);
  CHECK(normal[2] < 0.0);  // as that of the file's faces, whose x runs backwards
}

TEST_CASE("OBJ pattern: what cannot be a pattern is named, with the line or the face") {
  const auto says = [](const std::string& text, const std::vector<std::string>& parts,
                       const pattern::ReadOptions& o = {}) {
    const std::string said = refusal("hostile.obj", text, o);
    CAPTURE(said);
    for (const std::string& part : parts) CHECK(has(said, part));
  };
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n", drawn = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
  says(square, {"it has no faces"});
  says(square + "f 1 2 3 4\n", {"face 1 has no texture coordinates", "[mesh] file"});
  says(square + drawn + "f 1/1 2/2 3/3\nf 1 3 4\n", {"face 2 has no texture coordinates"});
  says(square + "vt 0.5 0.5\nf 1/1 2/1 3/1\n", {"all the same"});
  says(square + "vt 0 0\nvt 5 0\nvt 5 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n", {"texture_unit", "between 0.2", "and 1 m"});
  says(square + drawn + "f 1/1 2/2 3/3 4/4\nstitch 0 1 9 0.5\n", {"hostile.obj:10", "counted from 0; there are 4"});
  says(square + drawn + "f 1/1 2/2 3/3 4/4\nstitch 0 1 2 1.5\n", {"hostile.obj:10", "a fraction from 0 to 1"});
  says(square + drawn + "f 1/1 2/2 3/3\nf 1/1 4/4 3/3\n", {"face 2", "the piece folds over"});
  says(square + drawn + "f 1/1 2/2 3/3 4/4\n", {"no piece 'back': valid: piece"}, {0.0, false, {"back"}, ""});
  says(square + drawn + "f 1/1 2/2 3/3 4/4\n", {"the length of a unit must be wrong"}, {1000.0, false, {}, ""});
  says(square + "vt 0 0\nvt 1 0\nvt 3 0\nv 3 0 0\nf 1/1 2/2 5/3\n", {"face 1", "the piece has no area"});
  // Two triangles that touch at a point of the rim in one piece: a bow tie hung on a third.
  says(
      "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 2 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 2 0\nvt 0 1\nvt 2 1\nvt 1 1\n"
      "f 1/1 2/2 4/4\nf 2/2 3/3 5/5\nf 4/4 2/2 6/6\nf 2/2 5/5 6/6\nf 1/1 2/2 3/3\n",
      {"in texture coordinates (vt)"});
}

TEST_CASE("OBJ pattern: stitches to the inside of a piece are passed over with a remark") {
  long front = 0, back = 0;
  Obj obj = two_sheets(6, front, back);
  for (int j = 0; j <= 3; ++j) obj.stitch(front + 5 * j + 4, back + 5 * j + 2, back + 5 * j + 2, 0.0);
  const pattern::Pattern p = read("pocket.obj", obj.text());
  CHECK(p.stitches.empty());
  REQUIRE(p.notes.size() == 2);
  CHECK(has(p.notes[1], "3 of 4 lines 'stitch'"));  // the lowest is on the rim, but a point alone is no seam
}

}  // namespace test_obj

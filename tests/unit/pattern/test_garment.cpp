// Seams, meshes of panels and their places.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/weld.hpp"
#include "test_pattern_kit.hpp"

namespace test_garment {

using namespace voile;
using namespace voile::testing;
using pattern::Panel;
using pattern::SeamRequest;
using pattern::Sense;

namespace {

/// Largest difference of the fractions of length at which pairs of a seam lie on two straight edges from (0, y) up or down.
double along(const mesh::MeshData& m, Index v) {
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      if (m.triangles[t][i] == v) return m.texture[t][i][1];
  return -1.0;
}

}  // namespace

TEST_CASE("both sides of a seam have as many nodes at equal shares of their lengths, whatever the sizes of cells") {
  // The right edge of A (0.4 m) to the left edge of B (0.5 m): 25 % of ease; B is finer.
  const std::vector<Panel> panels{rectangle("A", 0.3, 0.4, 0.05), moved(rectangle("B", 0.3, 0.5, 0.02), {0.31, 0, 0})};
  const pattern::Garment g = pattern::make_garment(panels, {seam({"A/1"}, {"B/3"}, {"A@1", "B@0"})});
  REQUIRE(g.mesh.seams.size() == 1);
  const mesh::Seam& s = g.mesh.seams[0];
  CHECK(s.pairs.size() == 26);  // 0.5 m in cells of 0.02 m
  double sum = 0.0;
  for (std::size_t k = 0; k < s.pairs.size(); ++k) {
    CHECK(along(g.mesh, s.pairs[k][0]) / 0.4 == doctest::Approx(along(g.mesh, s.pairs[k][1]) / 0.5).epsilon(1e-9));
    sum += s.lengths[k];
  }
  CHECK(sum == doctest::Approx(0.45).epsilon(1e-12));
  const mesh::SurfaceMesh open(g.mesh);
  CHECK(open.component_count() == 2);
  double area = 0.0;
  for (Index t = 0; t < open.triangle_count(); ++t) area += open.area(t);
  CHECK(area == doctest::Approx(0.3 * 0.4 + 0.3 * 0.5).epsilon(1e-12));
  CHECK(open.group("A/1", 1).segments.size() == 25);
  CHECK(open.group("B", 2).triangles.size() > 500);
  const std::string line = mesh::seam_group(s.name);
  CHECK(open.group(line, 1).segments.size() == 50);  // both sides, of which a weld makes one
  const std::vector<double> mass(g.mesh.positions.size(), 1.0);
  const mesh::SurfaceMesh sewn(mesh::weld(g.mesh, {s.name}, g.mesh.positions, mass).data);
  CHECK(sewn.group(line, 1).segments.size() == 25);
  CHECK(pattern::garment_text(g, {0.2, 0.1}, {0.0, 0.0}).find("fabric: 0.27 m^2 in 2 panels, 0.039 kg") !=
        std::string::npos);
  CHECK(pattern::garment_text(g, {0.2, 0.1}, {0.01, 0.02})
            .find("fabric: 0.27 m^2 in 2 panels and 0.03 m^2 of seam allowances, 0.043 kg") != std::string::npos);
}

TEST_CASE("which points meet decides, not the order of edges") {
  const std::vector<Panel> panels{rectangle("A", 0.3, 0.4, 0.1), moved(rectangle("B", 0.3, 0.4, 0.1), {0.31, 0, 0})};
  for (const auto& meet : {std::vector<std::string>{"A@1", "B@0"}, {"A@2", "B@3"}, {}}) {
    const pattern::Garment g = pattern::make_garment(panels, {seam({"A/1"}, {"B/3"}, meet)});
    for (const auto& [v, w] : g.mesh.seams[0].pairs) CHECK(along(g.mesh, v) == doctest::Approx(along(g.mesh, w)));
  }
  const pattern::Garment twisted = pattern::make_garment(panels, {seam({"A/1"}, {"B/3"}, {"A@1", "B@3"})});
  CHECK(along(twisted.mesh, twisted.mesh.seams[0].pairs[0][0]) !=
        doctest::Approx(along(twisted.mesh, twisted.mesh.seams[0].pairs[0][1])));
}

TEST_CASE("one long edge to two: corners become nodes of both sides") {
  std::vector<Panel> panels{rectangle("A", 0.2, 0.5, 0.03), moved(rectangle("B", 0.2, 0.23, 0.03), {0.21, 0, 0}),
                            moved(rectangle("C", 0.2, 0.27, 0.03), {0.21, 0.23, 0})};
  const pattern::Garment g = pattern::make_garment(panels, {seam({"A/1"}, {"B/3", "C/3"}), seam({"B/2"}, {"C/0"})});
  const std::vector<std::string> names = mesh::open_seams(g.mesh, {"all"});
  const std::vector<double> mass(g.mesh.positions.size(), 1.0);
  const mesh::SurfaceMesh whole(mesh::weld(g.mesh, names, g.mesh.positions, mass).data);
  CHECK(whole.component_count() == 1);
  CHECK(whole.data().seams.empty());
  // The corners of B and C and the node of A opposite to them are one vertex, inside of nothing but the edge's end.
  Index boundary = 0;
  for (Index t = 0; t < whole.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) boundary += whole.neighbour(t, s) == no_index ? 1 : 0;
  const Index v = whole.vertex_count(), f = whole.triangle_count(), e = (3 * f + boundary) / 2;
  CHECK(v - e + f == 1);  // a disc without holes
}

TEST_CASE("a panel sewn to itself: a tube, a dart, and what is refused") {
  const std::vector<Panel> sheet{rectangle("A", 0.6, 0.3, 0.05)};
  SeamRequest against = seam({"A/1"}, {"A/3"});
  against.sense = Sense::against;
  const pattern::Garment tube = pattern::make_garment(sheet, {against});
  const std::vector<double> mass(tube.mesh.positions.size(), 1.0);
  CHECK(mesh::SurfaceMesh(mesh::weld(
                              tube.mesh, {"A/1-A/3"},
                              [&] {
                                std::vector<Vec3> x;
                                for (const Vec3& p : tube.mesh.positions) {
                                  const double a = 2.0 * std::numbers::pi * p[0] / 0.6;
                                  x.emplace_back(0.1 * std::cos(a), 0.1 * std::sin(a), p[1]);
                                }
                                return x;
                              }(),
                              mass)
                              .data)
            .component_count() == 1);
  against.sense = Sense::along;
  CHECK(has(refusal_of(sheet, {against}), "twist"));
  Panel dart = rectangle("D", 0.4, 0.3, 0.03);  // from the lower edge up
  const std::array<Vec2, 7> x{Vec2(0, 0),   Vec2(0.18, 0),  Vec2(0.2, 0.15), Vec2(0.22, 0),
                              Vec2(0.4, 0), Vec2(0.4, 0.3), Vec2(0, 0.3)};
  dart.piece.edges.clear();
  for (std::size_t k = 0; k < 7; ++k) dart.piece.edges.push_back({pattern::Curve::bezier({x[k], x[(k + 1) % 7]})});
  const pattern::Garment g = pattern::make_garment({dart}, {seam({"D/1"}, {"D/2"}, {"D@1", "D@3"})});
  CHECK(g.mesh.seams[0].pairs.size() == 5);  // 0.151 m in cells of 0.03 m, without the tip
  CHECK(has(refusal_of({dart}, {seam({"D/1"}, {"D/2"}, {"D@1", "D@2"})}), "collapse"));
  const pattern::Garment unsaid = pattern::make_garment({dart}, {seam({"D/1"}, {"D/2"})});
  CHECK(unsaid.seams.notes.empty());  // the tip says what meets
  CHECK(unsaid.mesh.seams[0].pairs == g.mesh.seams[0].pairs);
  Panel blunt = dart;
  const std::array<Vec2, 8> y{Vec2(0, 0),    Vec2(0.18, 0), Vec2(0.198, 0.15), Vec2(0.202, 0.15),
                              Vec2(0.22, 0), Vec2(0.4, 0),  Vec2(0.4, 0.3),    Vec2(0, 0.3)};
  blunt.piece.edges.clear();
  for (std::size_t k = 0; k < 8; ++k) blunt.piece.edges.push_back({pattern::Curve::bezier({y[k], y[(k + 1) % 8]})});
  const std::string message = refusal_of({blunt}, {seam({"D/1"}, {"D/3"}, {"D@1", "D@4"})});
  CHECK(has(message, "no common tip"));
  CHECK(has(message, "edge 2"));
}

TEST_CASE("holes are cut out of the mesh, and their edges are sewn as others") {
  // A sheet with a square hole, and a patch that fills it, drawn the other way round and from another corner.
  Panel sheet = rectangle("A", 0.6, 0.5, 0.03);
  sheet.piece.add_loop(rectangle("hole", 0.2, 0.1, 0.03).piece.edges);
  for (std::size_t k = 4; k < 8; ++k)
    sheet.piece.edges[k].curve = sheet.piece.edges[k].curve.mapped(Mat2::Identity(), {0.2, 0.15});
  const pattern::Garment open = pattern::make_garment({sheet}, {});
  const mesh::SurfaceMesh cut(open.mesh);
  CHECK(cut.group("A/0", 1).segments.size() == 20);
  CHECK(cut.group("A/4", 1).segments.size() == 7);
  for (const Index v : cut.group("A/6", 1).vertices)
    CHECK(cut.positions()[v][1] == doctest::Approx(0.25).epsilon(1e-12));
  const auto measures = [](const mesh::SurfaceMesh& m) {
    Index boundary = 0;
    double area = 0.0;
    for (Index t = 0; t < m.triangle_count(); ++t) {
      area += m.area(t);
      for (int s = 0; s < 3; ++s) boundary += m.neighbour(t, s) == no_index ? 1 : 0;
    }
    const Index v = m.vertex_count(), f = m.triangle_count(), e = (3 * f + boundary) / 2;
    return std::pair{area, v - e + f};  // the second is 1 for a disc, 0 for a ring
  };
  CHECK(measures(cut).first == doctest::Approx(0.3 - 0.02).epsilon(1e-12));
  CHECK(measures(cut).second == 0);
  CHECK(std::abs(sheet.piece.signed_area() - 0.28) < 1e-15);
  CHECK(pattern::garment_text(open, {1.0}, {0.0})
            .find("'A': 0.28 m^2, 0.28 kg, 0.6 m x 0.5 m, 8 edges of 2.8 m together, 1 hole\n") != std::string::npos);
  Panel patch = moved(rectangle("P", 0.1, 0.2, 0.03), {0.4, 0.15, 0});
  patch.turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // its edge 0 goes up where the right side of the hole is
  const std::vector<std::string> round{"A/4..7", "A/7"};
  const std::vector<std::string> about{"P/3", "P/0", "P/1", "P/2"}, back{"P/2", "P/1", "P/0", "P/3"};
  for (const auto& [to, meet] :
       {std::pair{about, std::vector<std::string>{}}, {about, {"A@4", "P@3"}}, {back, {"A@4", "P@3"}}}) {
    const pattern::Garment g = pattern::make_garment({sheet, patch}, {seam(round, to, meet)});
    CHECK(g.mesh.seams[0].pairs.size() == 22);  // 7 + 4 + 7 + 4 cells, round and back
    for (const auto& [v, w] : g.mesh.seams[0].pairs) CHECK((g.mesh.positions[v] - g.mesh.positions[w]).norm() < 1e-12);
    const std::vector<double> mass(g.mesh.positions.size(), 1.0);
    const mesh::SurfaceMesh whole(mesh::weld(g.mesh, mesh::open_seams(g.mesh, {"all"}), g.mesh.positions, mass).data);
    CHECK(measures(whole).first == doctest::Approx(0.3).epsilon(1e-12));
    CHECK(measures(whole).second == 1);
  }
  CHECK(has(refusal_of({sheet, patch}, {seam({"A/2..5"}, {"P/0"})}), "no edges lead from one to the other"));
  // The lower side of the hole goes as the lower edge does, and the strip between them becomes a tube, or a Moebius strip.
  CHECK(refusal_of({sheet}, {seam({"A/0"}, {"A/4"}, {"A@0", "A@4"})}).empty());
  CHECK(has(refusal_of({sheet}, {seam({"A/0"}, {"A/4"}, {"A@0", "A@5"})}), "twist"));
}

TEST_CASE("the points that a note names for a seam round a hole make the same seam as meet") {
  Panel sheet = rectangle("A", 0.6, 0.5, 0.03);
  sheet.piece.add_loop(rectangle("hole", 0.2, 0.1, 0.03).piece.edges);
  for (std::size_t k = 4; k < 8; ++k)
    sheet.piece.edges[k].curve = sheet.piece.edges[k].curve.mapped(Mat2::Identity(), {0.2, 0.15});
  for (const double y : {-0.5, 0.5}) {  // from either side of the hole
    const std::vector<Panel> panels{sheet, moved(rectangle("P", 0.6, 0.1, 0.03), {0, y, 0})};
    const pattern::Garment free = pattern::make_garment(panels, {seam({"P/0"}, {"A/4..7", "A/7"})});
    const std::string& note = free.seams.notes.at(0);
    const std::vector<std::string> named{note.substr(note.find("P@"), 3), note.substr(note.find("A@"), 3)};
    const pattern::Garment again = pattern::make_garment(panels, {seam({"P/0"}, {"A/4..7", "A/7"}, named)});
    CHECK(again.mesh.seams[0].pairs == free.mesh.seams[0].pairs);
  }
}

TEST_CASE("a hole with two sides that are sewn to each other is a dart with two tips") {
  Panel p = rectangle("A", 0.4, 0.6, 0.025);
  using pattern::Curve;
  p.piece.add_loop(
      {{Curve::bezier({{0.2, 0.1}, {0.23, 0.3}, {0.2, 0.5}})}, {Curve::bezier({{0.2, 0.5}, {0.17, 0.3}, {0.2, 0.1}})}});
  const pattern::Garment g = pattern::make_garment({p}, {seam({"A/4"}, {"A/5"}, {"A@4", "A@4"})});
  const std::vector<double> mass(g.mesh.positions.size(), 1.0);
  const mesh::SurfaceMesh sewn(mesh::weld(g.mesh, mesh::open_seams(g.mesh, {"all"}), g.mesh.positions, mass).data);
  Index boundary = 0;
  for (Index t = 0; t < sewn.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) boundary += sewn.neighbour(t, s) == no_index ? 1 : 0;
  const Index f = sewn.triangle_count();
  CHECK(sewn.vertex_count() - (3 * f + boundary) / 2 + f == 1);
  CHECK(boundary == 80);  // that of the rectangle
  CHECK(has(refusal_of({p}, {seam({"A/4"}, {"A/5"}, {"A@4", "A@5"})}), "collapse"));
  // A small hole beside a bent side of which coarse cells cut it off.
  Panel bent = p;
  bent.piece.edges[1].curve = Curve::bezier({{0.4, 0.0}, {0.8, 0.3}, {0.4, 0.6}});
  bent.piece.edges[4].curve = Curve::bezier({{0.5815, 0.222}, {0.584, 0.225}, {0.5815, 0.228}});
  bent.piece.edges[5].curve = Curve::bezier({{0.5815, 0.228}, {0.579, 0.225}, {0.5815, 0.222}});
  CHECK(refusal_of({bent}, {}).empty());
  bent.size = 0.5;
  CHECK(has(refusal_of({bent}, {}), "too coarse"));
}

TEST_CASE("seams that cannot be are refused with seam, piece and edge") {
  const std::vector<Panel> panels{rectangle("A", 0.3, 0.4, 0.1), moved(rectangle("B", 0.3, 0.4, 0.1), {0.4, 0, 0}),
                                  moved(rectangle("C", 0.3, 0.05, 0.02), {0.4, 0.5, 0})};
  CHECK(has(refusal_of(panels, {seam({"A/1"}, {"B/3"}), seam({"B/3"}, {"A/1"})}),
            "B/3 is sewn to A/1 in a seam already"));
  CHECK(has(refusal_of(panels, {seam({"A/1"}, {"A/1"})}), "edge A/1 is in it twice"));
  CHECK(has(refusal_of(panels, {seam({"A/9"}, {"B/3"})}), "'A/9': the piece has no such edge"));
  CHECK(has(refusal_of(panels, {seam({"A"}, {"B/3"})}), "PIECE/EDGE"));
  CHECK(has(refusal_of(panels, {seam({"E/1"}, {"B/3"})}), "no piece 'E'"));
  CHECK(has(refusal_of(panels, {seam({"A/1"}, {"B/3"}, {"A@0", "B@3"})}), "'A@0' is no end"));
  CHECK(has(refusal_of(panels, {seam({"A/1"}, {"C/3"})}), "more than 4 times"));
  // Two panels sewn at both sides, once with a twist.
  const std::string twist =
      refusal_of(panels, {seam({"A/1"}, {"B/3"}, {"A@1", "B@0"}), seam({"A/3"}, {"B/1"}, {"A@0", "B@2"})});
  CHECK(has(twist, "A/3 and B/1"));
  CHECK(has(twist, "twist"));
  CHECK(has(refusal_of({panels[0], panels[0]}, {}), "another piece has this name"));
}

TEST_CASE("a piece on a cylinder keeps its lengths; one that cannot be wrapped is refused") {
  Panel p = rectangle("A", 0.6, 0.3, 0.02);
  p.turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // y up becomes z up: the plane faces -y
  p.shift = {-0.3, -0.25, 1.0};
  p.wrap = pattern::Wrap{Vec3::UnitZ(), Vec3::Zero(), 0.0};
  for (const double x : {0.0, 0.3, 0.6}) {
    const Vec3 at = p.place({x, 0.1});
    CHECK(std::hypot(at[0], at[1]) == doctest::Approx(0.25).epsilon(1e-12));
    CHECK(at[2] == doctest::Approx(1.1));
    CHECK(std::atan2(at[0], -at[1]) == doctest::Approx((x - 0.3) / 0.25).epsilon(1e-12));
  }
  const pattern::Garment g = pattern::make_garment({p}, {});
  double worst = 0.0;
  for (std::size_t t = 0; t < g.mesh.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const double start =
          (g.mesh.positions[g.mesh.triangles[t][i]] - g.mesh.positions[g.mesh.triangles[t][(i + 1) % 3]]).norm();
      worst = std::max(worst, std::abs(start / (g.mesh.rest[t][i] - g.mesh.rest[t][(i + 1) % 3]).norm() - 1.0));
    }
  CHECK(worst < 1e-3);  // chords of cells of 0.02 m on a radius of 0.25 m: (h/r)^2/24
  p.wrap->axis = Vec3(0, 0.1, 1).normalized();
  CHECK(has(refusal_of({p}, {}), "leans by"));
  p.wrap = pattern::Wrap{Vec3::UnitZ(), Vec3::Zero(), 0.05};
  CHECK(has(refusal_of({p}, {}), "overlap itself"));
}

TEST_CASE("a piece on a cone keeps its lengths: isometric to round-off, between any two points") {
  // An upright plane 0.3 m in front of an oblique axis, up to the width of 3 radians round the cone.
  const Vec3 axis = Vec3(1, 2, 2) / 3.0, normal = Vec3(2, 1, -2) / 3.0, across = axis.cross(normal);
  for (const double half_angle : {0.5, -0.5, 0.05, -1.2, 1.4}) {
    INFO(half_angle);
    const double radius = 0.4, slope = std::tan(half_angle);
    Panel p = rectangle("A", 0.6, 0.3, 0.02);
    p.turn.col(0) = across;
    p.turn.col(1) = axis;
    p.turn.col(2) = across.cross(axis);
    const Vec3 foot(0.1, 0.2, 0.3);
    p.shift = foot + 0.3 * normal - 0.25 * across - 0.1 * axis;
    p.wrap = pattern::Wrap{axis, foot, radius, half_angle};
    // Where it comes to, in coordinates of the cone: way from the apex and angle round the axis.
    const Vec3 apex = foot - radius / slope * axis;
    const auto on_cone = [&](const Vec2& x) {
      const Vec3 d = p.place(x) - foot;
      const double height = d.dot(axis), r = (d - height * axis).norm();
      CHECK(std::abs(r - (radius + height * slope)) < 1e-12);
      return std::pair{(p.place(x) - apex).norm(), std::atan2(d.dot(across), d.dot(normal))};
    };
    double worst = 0.0;
    std::vector<Vec2> points;
    for (int i = 0; i <= 6; ++i)
      for (int j = 0; j <= 4; ++j) points.emplace_back(0.1 * i, 0.075 * j);
    for (const Vec2& x : points)
      for (const Vec2& y : points) {  // the cone unrolled: the law of cosines at its apex
        const auto [a, u] = on_cone(x);
        const auto [b, v] = on_cone(y);
        const double angle = (u - v) * std::sin(std::abs(half_angle)), half = std::sin(0.5 * angle);
        const double way = std::sqrt(std::pow(a - b, 2) + 4.0 * a * b * half * half);
        worst = std::max(worst, std::abs(way - (x - y).norm()));
      }
    CHECK(worst < 1e-12 * std::max(1.0, radius / std::sin(std::abs(half_angle))));
    // Its middle line stays straight and begins at the radius asked for; a line of it is a ray from the apex.
    const Vec3 low = p.place({0.25, 0.1}), high = p.place({0.25, 0.3});
    CHECK((low - (foot + radius * normal)).norm() < 1e-12);
    CHECK(std::abs((high - low).norm() - 0.2) < 1e-12);
    CHECK((high - low).normalized().dot(axis) == doctest::Approx(std::cos(half_angle)).epsilon(1e-12));
    // All round: an arc of the plane about the point that becomes the apex is an arc about the axis of its own length.
    const double way = std::abs(radius / std::sin(half_angle)), turned = 0.3 * std::sin(std::abs(half_angle));
    const Vec2 centre(0.25, 0.1 - radius / std::sin(half_angle));
    const double sense = half_angle > 0.0 ? 1.0 : -1.0;
    const Vec3 from = p.place({0.25, 0.1}),
               to = p.place(centre + way * Vec2(std::sin(turned), sense * std::cos(turned)));
    CHECK(std::abs((to - from).norm() - 2.0 * radius * std::sin(0.15)) < 1e-11);
    CHECK(std::abs((to - from).dot(axis)) < 1e-11);
  }
  // A cone with hardly an angle is the cylinder.
  Panel p = rectangle("A", 0.6, 0.3, 0.02);
  p.turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  p.shift = {-0.3, -0.25, 1.0};
  p.wrap = pattern::Wrap{Vec3::UnitZ(), Vec3(0, 0, 1.1), 0.0};
  const Vec3 cylinder = p.place({0.1, 0.3});
  p.wrap->half_angle = 1e-6;
  CHECK((p.place({0.1, 0.3}) - cylinder).norm() < 1e-6);
}

TEST_CASE("a piece that would pass the apex of its cone, or overlap itself on it, is refused") {
  Panel p = rectangle("A", 0.6, 0.3, 0.02);
  p.turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  p.shift = {-0.3, -0.25, 1.0};
  const auto says = [&](double from, double radius, double half_angle, const char* part) {
    p.wrap = pattern::Wrap{Vec3::UnitZ(), Vec3(0, 0, from), radius, half_angle};
    const std::string message = refusal_of({p}, {});
    INFO(message);
    CHECK((part ? has(message, part) && has(message, "piece 'A'") : message.empty()));
  };
  const double third = std::numbers::pi / 6.0;
  says(1.0, 0.25, third, nullptr);
  says(1.3, 0.25, -third, nullptr);
  says(1.0, 0.25, -third, nullptr);                // 0.5 m from the apex, the far end of the piece 0.2 m
  says(1.0, 0.1, -third, "would pass the apex");   // in the middle of the piece, after 0.2 m
  says(1.0, 0.15, -third, "would pass the apex");  // on its edge
  says(1.4, 0.1, third, "would pass the apex");    // 0.2 m below 1.4, so in the piece
  says(2.0, 0.1, third, "would pass the apex");    // all of it beyond
  says(1.0, 0.1, -third, "the apex of the cone at (0, 0, 1.173) m");
  says(1.0, 0.02, 0.4, "overlap itself on a cone, which unrolls to 140.2 degrees");
  says(1.0, 0.08, 0.1, "overlap itself");
  says(1.0, 0.1, 0.02, nullptr);
  says(1.0, 0.09, -0.02, "overlap itself");  // the upper edge comes nearer to the axis
  // A piece that lies round the apex as a horseshoe: the middle is out of it.
  p.piece.edges.clear();
  const std::vector<Vec2> x{{0, 0}, {0.6, 0}, {0.6, 0.5}, {0.4, 0.5}, {0.4, 0.2}, {0.2, 0.2}, {0.2, 0.5}, {0, 0.5}};
  for (std::size_t k = 0; k < 8; ++k) p.piece.edges.push_back({pattern::Curve::bezier({x[k], x[(k + 1) % 8]})});
  says(1.0, 0.35 * std::sin(1.4), -1.4, nullptr);
  says(1.0, 0.35 * std::sin(0.9), -0.9, "overlap itself");
}

TEST_CASE("cells too coarse for an outline are named") {
  Panel p = rectangle("A", 0.6, 0.3, 1.0);
  p.piece.edges.clear();
  const double h = 0.01;  // a thin crescent between two circles
  p.piece.edges.push_back({pattern::Curve::circle({0, 0}, {1, 0}, 0.5, false, true)});
  p.piece.edges.push_back({pattern::Curve::bezier({{1, 0}, {0.6, -0.6 + h}, {0.4, -0.6 + h}, {0, 0}})});
  const std::string message = refusal_of({p}, {});
  CHECK((message.empty() || has(message, "too coarse") || has(message, "cannot be meshed")));
}

TEST_CASE("The texture coordinates of a panel have its grain line along v") {
  pattern::Panel p = rectangle("a", 0.3, 0.1, 0.05);
  p.piece.grain = Vec2(1.0, 1.0).normalized();
  const pattern::Garment g = pattern::make_garment({p}, {});
  for (std::size_t t = 0; t < g.mesh.triangles.size(); ++t)
    for (std::size_t s = 0; s < 3; ++s) {
      const Vec3& x = g.mesh.positions[static_cast<std::size_t>(g.mesh.triangles[t][s])];
      CHECK(g.mesh.texture[t][s][1] == doctest::Approx((x[0] + x[1]) / std::sqrt(2.0)));
      CHECK(g.mesh.texture[t][s][0] == doctest::Approx((x[0] - x[1]) / std::sqrt(2.0)));
    }
}

TEST_CASE("the mesh of a garment names all files of its panels") {
  std::vector<Panel> panels{rectangle("A", 0.1, 0.1, 0.05), moved(rectangle("B", 0.1, 0.1, 0.05), {1, 0, 0})};
  CHECK(pattern::make_garment(panels, {}).mesh.source == "test");
  panels[1].file = "folder/b.svg";
  CHECK(pattern::make_garment(panels, {}).mesh.source == "test and b.svg");
  panels.push_back(moved(rectangle("C", 0.1, 0.1, 0.05), {2, 0, 0}));
  panels[2].file = "c.svg";
  CHECK(pattern::make_garment(panels, {}).mesh.source == "test and 2 more files");
}

}  // namespace test_garment

// Parts whose meshes do not match become one mesh without a gap, and keep their shape and groups.
#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <string>

#include "geometry/hanging_vertices.hpp"
#include "geometry/tie.hpp"
#include "geometry/tie_crossing.hpp"
#include "geometry/triangle_division.hpp"
#include "mesh/coincident.hpp"
#include "voile/errors.hpp"

namespace test_tie {

using namespace voile;

namespace {

/// Adds a parallelogram of n x m cells as a surface group; inner vertices move at random by up to `jitter` cells. Its first side
/// along `across` is a curve, `name` with " start".
void add(mesh::MeshData& data, const std::string& name, const Vec3& origin, const Vec3& along, const Vec3& across,
         int n, int m, double jitter = 0.0) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> move(-jitter, jitter);
  const auto base = static_cast<Index>(data.positions.size());
  const auto at = [&](int i, int j) { return base + static_cast<Index>(i * (m + 1) + j); };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= m; ++j) {
      const bool inside = i > 0 && i < n && j > 0 && j < m;
      const double u = i + (inside ? move(random) : 0.0), v = j + (inside ? move(random) : 0.0);
      data.positions.emplace_back(origin + u / n * along + v / m * across);
    }
  mesh::Group surface{name, 2, {}, {}, {}}, line{name + " start", 1, {}, {}, {}};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j)
      for (const mesh::Triangle& t :
           {mesh::Triangle{at(i, j), at(i + 1, j), at(i + 1, j + 1)}, {at(i, j), at(i + 1, j + 1), at(i, j + 1)}}) {
        surface.triangles.push_back(static_cast<Index>(data.triangles.size()));
        data.triangles.push_back(t);
      }
  for (Index v = base; v < static_cast<Index>(data.positions.size()); ++v) surface.vertices.push_back(v);
  for (int j = 0; j < m; ++j) line.segments.push_back({at(0, j), at(0, j + 1)});
  for (int j = 0; j <= m; ++j) line.vertices.push_back(at(0, j));
  data.groups.push_back(surface);
  data.groups.push_back(line);
}

double area(const mesh::MeshData& data, const std::string& name) {
  double sum = 0.0;
  for (const mesh::Group& g : data.groups)
    for (const Index t : g.name == name ? g.triangles : std::vector<Index>{})
      sum += mesh::triangle_area(data.positions[data.triangles[t][0]], data.positions[data.triangles[t][1]],
                                 data.positions[data.triangles[t][2]]);
  return sum;
}

double length(const mesh::MeshData& data, const std::string& name) {
  double sum = 0.0;
  for (const mesh::Group& g : data.groups)
    for (const mesh::Segment& s : g.name == name ? g.segments : std::vector<mesh::Segment>{})
      sum += (data.positions[s[0]] - data.positions[s[1]]).norm();
  return sum;
}

double smallest_angle(const mesh::MeshData& data) {
  double least = std::numbers::pi;
  for (const mesh::Triangle& t : data.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& x = data.positions[t[i]];
      const Vec3 a = data.positions[t[(i + 1) % 3]] - x, b = data.positions[t[(i + 2) % 3]] - x;
      least = std::min(least, std::atan2(a.cross(b).norm(), a.dot(b)));
    }
  return least * 180.0 / std::numbers::pi;
}

void turn(mesh::MeshData& data) {
  const Eigen::AngleAxisd by(0.7, Vec3(1, 2, -1).normalized());
  for (Vec3& x : data.positions) x = by * x + Vec3(3, -1, 2);
}

constexpr double tolerance = 1e-6;

geometry::Tied tie(mesh::MeshData& data) {
  mesh::merge_coincident(data, tolerance);
  return geometry::tie_parts(data, tolerance);
}

}  // namespace

TEST_CASE("two sheets of different cells meet without a gap") {
  for (const int other : {3, 4, 5, 7, 16, 23}) {
    mesh::MeshData data;
    add(data, "one", {0, 0, 0}, {-1, 0, 0}, {0, 1, 0}, 4, 8);
    add(data, "other", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, std::max(other / 2, 1), other);
    turn(data);
    CHECK(geometry::find_hanging(data, tolerance).count > 0);
    tie(data);
    CHECK(geometry::find_hanging(data, tolerance).count == 0);
    CHECK(area(data, "one") == doctest::Approx(1.0).epsilon(1e-12));
    CHECK(area(data, "other") == doctest::Approx(1.0).epsilon(1e-12));
    CHECK(length(data, "one start") == doctest::Approx(1.0).epsilon(1e-12));
    CHECK(length(data, "other start") == doctest::Approx(1.0).epsilon(1e-12));
    if (other > 3) CHECK(smallest_angle(data) > 4.5);
    const mesh::SurfaceMesh whole(data);
    CHECK(whole.component_count() == 1);
    CHECK(whole.joints().empty());
    double rim = 0.0;
    for (const mesh::Segment& e : mesh::rim_edges(data)) rim += (data.positions[e[0]] - data.positions[e[1]]).norm();
    CHECK(rim == doctest::Approx(6.0).epsilon(1e-12));
  }
}

TEST_CASE("a web stands anywhere on a sheet") {
  for (const double angle : {0.0, 0.3, 0.8})
    for (const double jitter : {0.0, 0.3})
      for (const int cells : {2, 9, 40}) {
        CAPTURE(angle);
        CAPTURE(jitter);
        CAPTURE(cells);
        mesh::MeshData data;
        add(data, "flange", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 12, 11, jitter);
        const Vec3 along(std::cos(angle), std::sin(angle), 0);
        add(data, "web", -0.6 * along, {0, 0, 0.3}, 1.3 * along, 2, cells);
        turn(data);
        CHECK(geometry::crossing_triangles(data, tolerance).empty());
        const geometry::Tied tied = tie(data);
        CHECK(tied.triangles > 0);
        CHECK(geometry::find_hanging(data, tolerance).count == 0);
        CHECK(area(data, "flange") == doctest::Approx(4.0).epsilon(1e-12));
        CHECK(area(data, "web") == doctest::Approx(0.39).epsilon(1e-12));
        CHECK(length(data, "web start") == doctest::Approx(1.3).epsilon(1e-12));
        if (cells == 9) CHECK(smallest_angle(data) > 3.0);
        const mesh::SurfaceMesh whole(data);
        double foot = 0.0;
        for (const mesh::Joint& j : whole.joints()) {
          CHECK(j.sides.size() == 3);
          foot += (data.positions[j.edge[0]] - data.positions[j.edge[1]]).norm();
        }
        CHECK(foot == doctest::Approx(1.3).epsilon(1e-12));
      }
}

TEST_CASE("parts that pass through each other are joined along the line") {
  for (const double angle : {0.0, 0.3, 0.8})
    for (const double offset : {0.0, 0.013, 0.2})
      for (const double jitter : {0.0, 0.25})
        for (const int cells : {4, 9, 24}) {
          CAPTURE(angle);
          CAPTURE(offset);
          CAPTURE(jitter);
          CAPTURE(cells);
          mesh::MeshData data;
          add(data, "level", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 12, 12, jitter);
          const Vec3 along(std::cos(angle), std::sin(angle), 0), aside(-along[1], along[0], 0);
          add(data, "upright", Vec3(-0.5 * along + offset * aside) - Vec3(0, 0, 0.5), {0, 0, 1}, along, cells, cells,
              jitter);
          turn(data);
          REQUIRE_FALSE(geometry::crossing_triangles(data, tolerance).empty());
          tie(data);
          CHECK(geometry::find_hanging(data, tolerance).count == 0);
          CHECK(geometry::crossing_triangles(data, tolerance).empty());
          CHECK(area(data, "level") == doctest::Approx(4.0).epsilon(1e-12));
          CHECK(area(data, "upright") == doctest::Approx(1.0).epsilon(1e-12));
          CHECK(smallest_angle(data) > 1.0);
          const mesh::SurfaceMesh whole(data);
          CHECK(whole.component_count() == 1);
          double line = 0.0;
          for (const mesh::Joint& j : whole.joints()) {
            CHECK(j.sides.size() == 4);
            line += (data.positions[j.edge[0]] - data.positions[j.edge[1]]).norm();
          }
          CHECK(line == doctest::Approx(1.0).epsilon(1e-12));
        }
}

TEST_CASE("plates of an egg crate on a sheet are one") {
  for (const int cells : {5, 8}) {
    mesh::MeshData data;
    add(data, "sheet", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 11, 11, 0.2);
    for (const double at : {-0.41, 0.37}) {
      add(data, "along", {-0.8, at, 0}, {0, 0, 0.4}, {1.6, 0, 0}, 3, cells);
      add(data, "across", {at, -0.8, 0}, {0, 0, 0.4}, {0, 1.6, 0}, 3, cells + 2);
    }
    turn(data);
    tie(data);
    const mesh::SurfaceMesh whole(data);
    CHECK(whole.component_count() == 1);
    CHECK(geometry::find_hanging(data, tolerance).count == 0);
    CHECK(geometry::crossing_triangles(data, tolerance).empty());
    double feet = 0.0, lines = 0.0;
    for (const mesh::Joint& j : whole.joints())
      (j.sides.size() == 3 ? feet : lines) += (data.positions[j.edge[0]] - data.positions[j.edge[1]]).norm();
    CHECK(feet == doctest::Approx(6.4).epsilon(1e-12));
    CHECK(lines == doctest::Approx(1.6).epsilon(1e-12));
  }
}

TEST_CASE("a tube that lies on a sheet is not joined to it, and crossings are left where that is asked for") {
  mesh::MeshData touching, crossing;
  add(touching, "sheet", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 8, 8);
  const std::size_t first = touching.positions.size();
  add(touching, "roof", {0, -0.5, 0}, {0, 1, 0}, {0.3, 0, 0}, 4, 6);
  for (std::size_t v = first; v < touching.positions.size(); ++v) {
    Vec3& x = touching.positions[v];
    x[0] -= 0.15;
    x[2] = x[0] * x[0];
  }
  CHECK(geometry::crossing_triangles(touching, tolerance).empty());
  add(crossing, "level", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 5, 5);
  add(crossing, "upright", {-0.5, 0.1, -0.5}, {0, 0, 1}, {1, 0, 0}, 4, 4);
  geometry::tie_parts(crossing, tolerance, {}, geometry::Crossing::left);
  CHECK(mesh::SurfaceMesh(crossing).component_count() == 2);
}

TEST_CASE("ends of lines and corners stay where they are, whether curves name them or not") {
  for (const bool named : {true, false}) {
    CAPTURE(named);
    mesh::MeshData data;
    add(data, "plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 4, 4);
    add(data, "web", {0.07, 0.5, 0}, {0, 0, 0.25}, {0.75, 0, 0}, 1, 3);
    add(data, "other", {0.86, 0.5, 0}, {0, 0, 0.25}, {0.14, 0, 0}, 1, 1);
    if (!named) std::erase_if(data.groups, [](const mesh::Group& g) { return g.dimension == 1; });
    tie(data);
    CHECK(geometry::find_hanging(data, tolerance).count == 0);
    CHECK(area(data, "plate") == doctest::Approx(1.0).epsilon(1e-12));
    CHECK(area(data, "web") == doctest::Approx(0.1875).epsilon(1e-12));
    CHECK(area(data, "other") == doctest::Approx(0.035).epsilon(1e-12));
    if (!named) continue;
    CHECK(length(data, "web start") == doctest::Approx(0.75).epsilon(1e-12));
    CHECK(length(data, "other start") == doctest::Approx(0.14).epsilon(1e-12));
  }
}

TEST_CASE(
    "sheets above and below another are tied to it, whether they match or not; loads on points stay on those of the "
    "file") {
  for (const int below : {24, 25, 20, 1}) {
    CAPTURE(below);
    mesh::MeshData data;
    add(data, "sheet", {0, -0.1, 0}, {1, 0, 0}, {0, 0.2, 0}, 20, 5);
    add(data, "above", {0, 0, 0}, {0, 0, 0.1}, {1, 0, 0}, 4, 24);
    add(data, "below", {0, 0, 0}, {0, 0, -0.1}, {1, 0, 0}, 4, below);
    std::vector<mesh::Segment> rims = mesh::rim_edges(data);
    mesh::merge_coincident(data, tolerance, &rims);
    geometry::tie_parts(data, tolerance, rims);
    const mesh::SurfaceMesh whole(data);
    double line = 0.0;
    for (const mesh::Joint& j : whole.joints()) {
      CHECK(j.sides.size() == 4);
      line += (data.positions[j.edge[0]] - data.positions[j.edge[1]]).norm();
    }
    CHECK(line == doctest::Approx(1.0).epsilon(1e-9));
    const mesh::Group& foot = whole.group("above start", 1);
    CHECK(foot.vertices.size() > 25);
    CHECK(foot.places().size() == 25);
  }
}

TEST_CASE("ties keep group borders, points and textures") {
  mesh::MeshData data;
  add(data, "left", {-1, -1, 0}, {1, 0, 0}, {0, 2, 0}, 5, 10);
  add(data, "right", {0, -1, 0}, {1, 0, 0}, {0, 2, 0}, 5, 10);
  add(data, "web", {-0.53, 0.11, 0}, {0, 0, 0.3}, {1.1, 0.05, 0}, 2, 7);
  const Index point = 3 * 11 + 6;  // (-0.4, 0.2), which would move
  data.groups.push_back({"point", 0, {point}, {}, {}});
  const Vec3 place = data.positions[point];
  for (const mesh::Triangle& t : data.triangles) {
    std::array<Vec2, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = (2.0 * data.positions[t[i]].head<2>()).array() + 1.0;
    data.texture.push_back(corners);
  }
  tie(data);
  CHECK(area(data, "left") == doctest::Approx(2.0).epsilon(1e-12));
  CHECK(area(data, "right") == doctest::Approx(2.0).epsilon(1e-12));
  const auto group =
      std::find_if(data.groups.begin(), data.groups.end(), [](const auto& g) { return g.name == "point"; });
  REQUIRE(group->vertices.size() == 1);
  CHECK((data.positions[group->vertices[0]] - place).norm() == 0.0);
  REQUIRE(data.texture.size() == data.triangles.size());
  double worst = 0.0;
  for (std::size_t t = 0; t < data.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2 expected = (2.0 * data.positions[data.triangles[t][i]].head<2>()).array() + 1.0;
      worst = std::max(worst, (data.texture[t][i] - expected).norm());
    }
  CHECK(worst < 1e-12);
}

TEST_CASE("a curve that two rings divide differently closes within the tolerance") {
  mesh::MeshData data;
  const auto ring = [&](double inner, int n, double phase, const std::string& name) {
    add(data, name, Vec3::Zero(), {1, 0, 0}, {0, 1, 0}, 3, n);
    mesh::Group& surface = data.groups[data.groups.size() - 2];
    for (const Index v : surface.vertices) {
      const Vec3 x = data.positions[v];
      const double a = 2.0 * std::numbers::pi * (x[1] + phase / n), r = inner + 0.5 * x[0];
      data.positions[v] = {r * std::cos(a), r * std::sin(a), 0.0};
    }
  };
  ring(1.0, 48, 0.0, "inner");
  ring(1.5, 67, 0.3, "outer");
  mesh::merge_coincident(data, 0.004);
  geometry::tie_parts(data, 0.004);
  CHECK(geometry::find_hanging(data, 0.004, geometry::Beside::skipped).count == 0);
  const mesh::SurfaceMesh whole(data);
  CHECK(whole.component_count() == 1);
  double rim = 0.0;
  for (const mesh::Segment& e : mesh::rim_edges(data)) rim += (data.positions[e[0]] - data.positions[e[1]]).norm();
  CHECK(rim == doctest::Approx(2.0 * 48 * std::sin(std::numbers::pi / 48) + 4.0 * 67 * std::sin(std::numbers::pi / 67))
                   .epsilon(1e-9));
}

TEST_CASE("a tolerance beyond the height of a triangle is refused") {
  mesh::MeshData data;
  add(data, "one", {0, 0, 0}, {-1, 0, 0}, {0, 1, 0}, 4, 4);
  add(data, "other", {0, 0.11, 0}, {1, 0, 0}, {0, 1, 0}, 4, 4);
  CHECK_THROWS_WITH_AS(geometry::tie_parts(data, 0.1), doctest::Contains("make merge_tolerance smaller"), UserError);
}

TEST_CASE("a polygon is divided along lines, and not if they cross") {
  const std::vector<Vec2> points{{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 1.2}};
  const auto parts = geometry::divide_polygon(points, {0, 1, 2, 3, 4}, {{1, 5}, {5, 1}});
  double sum = 0.0;
  bool along = false;
  for (const auto& [a, b, c] : parts) {
    const Vec2 u = points[b] - points[a], v = points[c] - points[a];
    sum += 0.5 * (u[0] * v[1] - u[1] * v[0]);
    const std::set<Index> corners{a, b, c};
    along = along || (corners.count(1) > 0 && corners.count(5) > 0);
  }
  CHECK(sum == doctest::Approx(4.0));
  CHECK(along);
  CHECK(geometry::divide_polygon(points, {0, 1, 2, 3, 4}, {{0, 3}, {2, 4}}).empty());
}

}  // namespace test_tie

// The exact check of intersections against brute force in integers, which finds the corners of what two triangles have
// in common, by another way than the predicates do.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <unistd.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <string>

#include "extent.hpp"
#include "formats/triangle_file.hpp"
#include "geometry/intersections.hpp"
#include "voile/errors.hpp"

namespace test_intersections {

using namespace voile;
namespace fs = std::filesystem;

namespace {

using Whole = Eigen::Matrix<std::int64_t, 3, 1>;
using Corners = std::array<Whole, 3>;

/// The point x / w.
struct Ratio {
  Whole x;
  std::int64_t w = 1;
};

bool on_segment(const Ratio& p, const Whole& a, const Whole& b) {
  const Whole from = p.x - p.w * a, along = b - a;
  const std::int64_t t = from.dot(along);
  return from.cross(along).isZero(0) && t >= 0 && t <= p.w * along.squaredNorm() &&
         (!along.isZero(0) || from.isZero(0));
}

bool in_triangle(const Ratio& p, const Corners& c) {
  const Whole n = (c[1] - c[0]).cross(c[2] - c[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Whole &a = c[k], &b = c[(k + 1) % 3];
    if (n.isZero(0) && on_segment(p, a, b)) return true;
    if (!n.isZero(0) && (b - a).cross(Whole(p.x - p.w * a)).dot(n) < 0) return false;
  }
  return !n.isZero(0) && Whole(p.x - p.w * c[0]).dot(n) == 0;
}

/// Adds where the segments cross, if they are not parallel.
void add_crossing(const Whole& a, const Whole& b, const Whole& c, const Whole& d, std::vector<Ratio>& points) {
  const Whole u = b - a, v = d - c, n = u.cross(v), between = c - a;
  const std::int64_t w = n.squaredNorm(), t = between.cross(v).dot(n), s = between.cross(u).dot(n);
  if (w > 0 && between.dot(n) == 0 && t >= 0 && t <= w && s >= 0 && s <= w) points.push_back({w * a + t * u, w});
}

/// Adds where the sides of one pierce the other.
void add_piercing(const Corners& one, const Corners& other, std::vector<Ratio>& points) {
  const Whole n = (other[1] - other[0]).cross(other[2] - other[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Whole &a = one[k], &b = one[(k + 1) % 3];
    const std::int64_t above = (a - other[0]).dot(n), below = (b - other[0]).dot(n);
    if (!((above > 0 && below < 0) || (above < 0 && below > 0))) continue;
    const std::int64_t sign = above > below ? 1 : -1;
    const Ratio p{sign * (above * b - below * a), sign * (above - below)};
    if (in_triangle(p, other)) points.push_back(p);
  }
}

/// Every corner of the (convex) intersection is among these, and all of them are in it.
std::vector<Ratio> common_points(const Corners& one, const Corners& other) {
  std::vector<Ratio> points;
  for (const Whole& a : one)
    if (in_triangle({a}, other)) points.push_back({a});
  for (const Whole& a : other)
    if (in_triangle({a}, one)) points.push_back({a});
  add_piercing(one, other, points);
  add_piercing(other, one, points);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t l = 0; l < 3; ++l) add_crossing(one[k], one[(k + 1) % 3], other[l], other[(l + 1) % 3], points);
  return points;
}

enum class Answer { no, yes, unknown };

Answer oracle(const std::vector<Whole>& x, const mesh::Triangle& one, const mesh::Triangle& other) {
  const Corners a{x[one[0]], x[one[1]], x[one[2]]}, b{x[other[0]], x[other[1]], x[other[2]]};
  std::vector<Index> common;
  for (const Index v : one)
    if (std::count(other.begin(), other.end(), v) && !std::count(common.begin(), common.end(), v)) common.push_back(v);
  const auto is_flat = [](const Corners& c) { return (c[1] - c[0]).cross(c[2] - c[0]).isZero(0); };
  if (common.size() == 3) return Answer::yes;
  if (common.size() == 2 && is_flat(a) && is_flat(b)) return Answer::unknown;
  for (const Ratio& p : common_points(a, b))
    if (common.empty() || !on_segment(p, x[common.front()], x[common.back()])) return Answer::yes;
  return Answer::no;
}

struct Random {
  std::vector<Whole> whole;
  std::vector<Vec3> positions;
  std::vector<mesh::Triangle> triangles;
};

/// Triangles on a small grid, where touching, coplanar and degenerate ones abound; vertices are shared, and others
/// coincide under different numbers.
Random random_triangles(unsigned seed, int vertices, int triangles, int cells, int layers) {
  std::mt19937 generator(seed);
  const auto number = [&](int n) { return static_cast<std::int64_t>(generator() % static_cast<unsigned>(n)); };
  Random r;
  for (int v = 0; v < vertices; ++v) {
    r.whole.emplace_back(number(cells), number(cells), number(layers));
    r.positions.push_back(r.whole.back().cast<double>());
  }
  for (int t = 0; t < triangles; ++t) {
    mesh::Triangle corners{};
    for (Index& v : corners) v = static_cast<Index>(number(vertices));
    r.triangles.push_back(corners);
  }
  return r;
}

std::size_t compare_with_oracle(const Random& r) {
  const auto found = geometry::intersecting_triangles(r.positions, r.triangles);
  CHECK(std::is_sorted(found.begin(), found.end()));
  CHECK(std::adjacent_find(found.begin(), found.end()) == found.end());
  int wrong = 0;
  const auto n = static_cast<Index>(r.triangles.size());
  for (Index i = 0; i < n; ++i)
    for (Index j = i + 1; j < n; ++j) {
      const bool is_found = std::binary_search(found.begin(), found.end(), std::pair(i, j));
      const Answer answer = oracle(r.whole, r.triangles[i], r.triangles[j]);
      if (answer == Answer::unknown ? is_found : is_found != (answer == Answer::yes)) ++wrong;
    }
  CHECK(wrong == 0);
  return found.size();
}

std::size_t count(const std::vector<Vec3>& x, const std::vector<mesh::Triangle>& triangles) {
  return geometry::intersecting_triangles(x, triangles).size();
}

}  // namespace

TEST_CASE("pairs that intersect are those of brute force in integers") {
  std::size_t pairs = 0;
  for (unsigned seed = 1; seed <= extent(4U, 1U); ++seed) {
    pairs += compare_with_oracle(random_triangles(seed, 900, 300, 12, 12));  // few share a vertex
    pairs += compare_with_oracle(random_triangles(seed, 60, 120, 5, 5));     // many share a vertex
    pairs += compare_with_oracle(random_triangles(seed, 12, 60, 4, 4));      // many share an edge
    pairs += compare_with_oracle(random_triangles(seed, 30, 60, 4, 1));      // all in a plane
    pairs += compare_with_oracle(random_triangles(seed, 20, 60, 2, 2));      // many of zero area
  }
  CHECK(pairs > extent(1000U, 250U));
}

TEST_CASE("the scale makes no difference, nor does the last digit go unnoticed") {
  const Random r = random_triangles(7, 60, 120, 5, 5);
  for (const double scale : {0x1p-300, 0x1p300}) {
    std::vector<Vec3> x = r.positions;
    for (Vec3& p : x) p *= scale;
    CHECK(geometry::intersecting_triangles(x, r.triangles) ==
          geometry::intersecting_triangles(r.positions, r.triangles));
  }
  const double z = 0.1, above = std::nextafter(z, 1.0);
  const std::vector<mesh::Triangle> two{{0, 1, 2}, {3, 4, 5}};
  const std::vector<Vec3> floor{{0, 0, z}, {1, 0, z}, {0, 1, z}};
  for (const auto& [height, expected] : {std::pair(z, 1U), std::pair(above, 0U)}) {
    std::vector<Vec3> x = floor;
    x.insert(x.end(), {Vec3(0.3, 0.3, height), Vec3(0.3, 0.4, 1.0), Vec3(0.4, 0.3, 1.0)});
    CHECK(count(x, two) == expected);
  }
}

TEST_CASE("neighbours in a sheet do not intersect, however it is bent, until it passes through itself") {
  std::vector<Vec3> flat, rolled, wound;
  std::vector<mesh::Triangle> triangles;
  constexpr Index n = 24;
  for (Index j = 0; j <= n; ++j)
    for (Index i = 0; i <= n; ++i) {
      const double s = 0.25 * i, y = 0.1 * j;
      flat.emplace_back(s, y, 0.0);
      rolled.emplace_back(std::cos(s), y, std::sin(s));                        // six radians: not yet closed
      wound.emplace_back(std::cos(1.5 * s), y + 0.01 * s, std::sin(1.5 * s));  // nine radians on one cylinder
    }
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      triangles.push_back({a, b, d});
      triangles.push_back({a, d, c});
    }
  CHECK(count(flat, triangles) == 0);
  CHECK(count(rolled, triangles) == 0);
  CHECK(count(wound, triangles) > 0);
  // Folded onto itself along a line of vertices: each triangle meets its image.
  for (Vec3& x : flat)
    if (x[0] > 3.0) x[0] = 6.0 - x[0];
  CHECK(count(flat, triangles) >= n * n);
}

TEST_CASE("pairs of bodies that need no look are left out") {
  const geometry::TriangleSoup one = geometry::sphere_surface(Vec3(0, 0, 0), 1.0, 1),
                               other = geometry::sphere_surface(Vec3(1, 0, 0), 1.0, 2);
  std::vector<Vec3> x = one.positions;
  std::vector<mesh::Triangle> triangles = one.triangles;
  std::vector<Index> body(triangles.size(), 4);
  const auto shift = static_cast<Index>(x.size());
  x.insert(x.end(), other.positions.begin(), other.positions.end());
  for (const auto& [a, b, c] : other.triangles) triangles.push_back({a + shift, b + shift, c + shift});
  triangles.insert(triangles.end(), 2, {0, 1, 2});  // twice the same: a pair inside body 9
  body.resize(triangles.size() - 2, 9);
  body.resize(triangles.size(), 7);
  const auto all = geometry::intersecting_triangles(x, triangles);
  const auto across = geometry::intersecting_triangles(x, triangles, body, [](Index a, Index b) { return a == b; });
  CHECK(across.size() > 10);
  CHECK(all.size() > across.size());
  std::vector<geometry::TrianglePair> expected;
  for (const auto& [i, j] : all)
    if (body[i] != body[j]) expected.emplace_back(i, j);
  CHECK(across == expected);
  // Two bodies that have to do with the third alone, as obstacles have with a sheet.
  const auto idle = [](Index a, Index b) { return a != 4 && b != 4; };
  const auto with_one = geometry::intersecting_triangles(x, triangles, body, idle);
  CHECK(with_one.size() > 10);
  expected.clear();
  for (const auto& [i, j] : all)
    if (!idle(body[i], body[j])) expected.emplace_back(i, j);
  CHECK(with_one == expected);
  // Shared among three, each pair is found by one of them.
  for (const auto& skip : {std::function<bool(Index, Index)>(idle),
                           std::function<bool(Index, Index)>([](Index a, Index b) { return a == b; })}) {
    std::vector<geometry::TrianglePair> together;
    for (int part = 0; part < 3; ++part) {
      const auto own = geometry::intersecting_triangles(x, triangles, body, skip, {part, 3});
      together.insert(together.end(), own.begin(), own.end());
    }
    std::sort(together.begin(), together.end());
    CHECK(together == geometry::intersecting_triangles(x, triangles, body, skip));
  }
  CHECK(geometry::intersecting_triangles(x, triangles, body, [](Index, Index) { return true; }).empty());
}

TEST_CASE(
    "shared among many, each pair is found once, also where many boxes begin at one place or there are fewer than "
    "parts") {
  std::srand(11);
  std::vector<Vec3> x;
  std::vector<mesh::Triangle> triangles;
  for (Index t = 0; t < 240; ++t) {
    const Vec3 centre = 2.0 * Vec3::Random();
    for (Index k = 0; k < 3; ++k) {
      x.emplace_back(centre + 0.7 * Vec3::Random());
      if (t % 2 == 0) x.back() = x.back().array().round();  // on a grid, so that they touch
    }
    triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  const auto skip = [](Index, Index) { return false; };
  const std::vector<Index> body(triangles.size(), 0);
  const auto all = geometry::intersecting_triangles(x, triangles);
  REQUIRE(all.size() > 200);
  for (const int parts : {2, 7, 500}) {
    std::vector<geometry::TrianglePair> together;
    std::size_t most = 0;
    for (int part = 0; part < parts; ++part) {
      const auto own = geometry::intersecting_triangles(x, triangles, body, skip, {part, parts});
      together.insert(together.end(), own.begin(), own.end());
      most = std::max(most, own.size());
    }
    std::sort(together.begin(), together.end());
    CAPTURE(parts);
    CHECK(together == all);
    if (parts < 10) CHECK(most * static_cast<std::size_t>(parts) < 3 * all.size());
  }
}

TEST_CASE("the triangles of the pairs are written for ParaView") {
  const fs::path file = fs::temp_directory_path() / fmt::format("voile_pairs_{}.vtk", ::getpid());
  const std::vector<Vec3> x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.25, -1}, {0.25, 0.25, 0.5}, {0.1, 0.2, 0.7}};
  const std::vector<mesh::Triangle> triangles{{0, 1, 2}, {3, 4, 5}};
  const auto pairs = geometry::intersecting_triangles(x, triangles);
  CHECK(pairs == std::vector<geometry::TrianglePair>{{0, 1}});
  geometry::write_pairs(file, x, triangles, {3, 8}, pairs);
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  CHECK(text.str() ==
        "# vtk DataFile Version 3.0\nintersecting triangles\nASCII\nDATASET POLYDATA\nPOINTS 6 double\n"
        "0 0 0\n1 0 0\n0 1 0\n0.25 0.25 -1\n0.25 0.25 0.5\n0.1 0.2 0.7\nPOLYGONS 2 8\n3 0 1 2\n3 3 4 5\n"
        "CELL_DATA 2\nFIELD fields 3\npair 1 2 int\n0\n0\ntriangle 1 2 int\n0\n1\nbody 1 2 int\n3\n8\n");
  geometry::write_pairs(file, x, triangles, {}, {});
  CHECK(fs::file_size(file) > 0);
  fs::remove(file);
  CHECK_THROWS_AS(geometry::write_pairs(file, x, triangles, {3}, pairs), InternalError);
  CHECK_THROWS_AS(geometry::write_pairs(file, x, triangles, {}, {{0, 2}}), InternalError);
  CHECK_THROWS_AS(
      geometry::write_pairs(fs::temp_directory_path() / "voile_no_folder" / "x.vtk", x, triangles, {}, pairs),
      UserError);
}

TEST_CASE("the check of intersections refuses what is no triangle") {
  const std::vector<Vec3> x{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS((void)count(x, {{0, 1, 3}}), InternalError);
  CHECK_THROWS_AS((void)count(x, {{0, -1, 2}}), InternalError);
  CHECK_THROWS_AS((void)count({{0, 0, 0}, {1, nan, 0}, {0, 1, 0}}, {{0, 1, 2}}), InternalError);
  CHECK_THROWS_AS((void)geometry::intersecting_triangles(x, {{0, 1, 2}}, {}, [](Index, Index) { return false; }),
                  InternalError);
  CHECK(count({}, {}) == 0);
  CHECK(geometry::cgal_version().find('.') != std::string::npos);
}

}  // namespace test_intersections

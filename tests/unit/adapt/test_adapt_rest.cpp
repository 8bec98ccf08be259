// Remeshing in charts, on curved rest shapes and curves, across creases, and within what contact allows.
#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "contact/distance.hpp"
#include "test_adapt_kit.hpp"
#include "test_relative.hpp"

namespace test_adapt_rest {

using namespace voile;
using namespace voile::testing;

namespace {

constexpr double pi = std::numbers::pi;

std::vector<double> uniform(const mesh::SurfaceMesh& m, double h) {
  return std::vector<double>(static_cast<std::size_t>(m.vertex_count()), h);
}

/// Half a cylinder of radius 1 and length 1 about z, from a mesh of the unit square.
Vec3 on_cylinder(const Vec3& x) {
  return {std::cos(pi * x[0]), std::sin(pi * x[0]), x[1]};
}

/// Largest distance of vertices from radius 1, and the area's error against `exact`.
double radius_error(const mesh::SurfaceMesh& m) {
  double worst = 0.0;
  for (const Vec3& x : m.positions()) worst = std::max(worst, std::abs(std::hypot(x[0], x[1]) - 1.0));
  return worst;
}

/// Two panels side by side, sewn at x = 1/2: each has its own chart, turned and shifted.
struct Panels {
  Mat3 turn[2];
  Vec3 shift[2];
  mesh::MeshData data;
  [[nodiscard]] Vec3 chart(int k, const Vec3& x) const { return turn[k] * x + shift[k]; }
};

Panels two_panels(int n) {
  Panels p;
  p.data = square(Pattern::diagonal, n);
  p.turn[0] = Eigen::AngleAxisd(0.7, Vec3::UnitZ()).toRotationMatrix();
  p.turn[1] = Eigen::AngleAxisd(-2.1, Vec3::UnitZ()).toRotationMatrix();
  p.shift[0] = {3, 1, 0};
  p.shift[1] = {2.9, 1.1, 0};  // the panels lie over each other
  for (const mesh::Triangle& t : p.data.triangles) {
    const double middle = (p.data.positions[t[0]] + p.data.positions[t[1]] + p.data.positions[t[2]])[0] / 3;
    const int k = middle < 0.5 ? 0 : 1;
    p.data.rest.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) p.data.rest.back()[i] = p.chart(k, p.data.positions[t[i]]);
  }
  return p;
}

/// Largest distance between two piecewise linear surfaces at equal rest positions in a plane, sampled.
double sampled_distance(const mesh::SurfaceMesh& a, const std::vector<Vec3>& xa, const mesh::SurfaceMesh& b,
                        const std::vector<Vec3>& xb, int n) {
  const auto at = [](const mesh::SurfaceMesh& m, const std::vector<Vec3>& x, const Vec3& p) {
    for (Index t = 0; t < m.triangle_count(); ++t) {
      const Vec3 &q0 = m.positions()[m.triangles()[t][0]], &q1 = m.positions()[m.triangles()[t][1]],
                 &q2 = m.positions()[m.triangles()[t][2]];
      const double area = (q1 - q0).cross(q2 - q0)[2], w1 = (p - q0).cross(q2 - q0)[2] / area,
                   w2 = (q1 - q0).cross(p - q0)[2] / area;
      if (std::min({w1, w2, 1 - w1 - w2}) < -1e-12) continue;
      return Vec3((1 - w1 - w2) * x[m.triangles()[t][0]] + w1 * x[m.triangles()[t][1]] + w2 * x[m.triangles()[t][2]]);
    }
    FAIL("a point lies outside");
    return Vec3(Vec3::Zero());
  };
  double worst = 0.0;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const Vec3 p((i + 0.37) / (n + 1), (j + 0.61) / (n + 1), 0);
      worst = std::max(worst, (at(a, xa, p) - at(b, xb, p)).norm());
    }
  return worst;
}

}  // namespace

TEST_CASE("a seam between two panels stays one line in two charts") {
  const Panels p = two_panels(8);
  mesh::SurfaceMesh m(p.data);
  const RestSurface rest(m);
  for (const double h : {0.03, 0.1, 0.05}) {
    const Remeshed r = remeshed(m, rest, uniform(m, h));
    const mesh::SurfaceMesh after(r.mesh);
    check_result(m, r, after);
    CHECK(total_area(after) == relative(1.0).epsilon(1e-12));
    Index seams = 0;
    double length = 0.0, worst = 0.0;
    for (Index t = 0; t < after.triangle_count(); ++t) {
      const Vec3 middle = (after.start_corner(t, 0) + after.start_corner(t, 1) + after.start_corner(t, 2)) / 3;
      for (int i = 0; i < 3; ++i)
        worst = std::max(worst,
                         (after.rest_corner(t, i) - p.chart(middle[0] < 0.5 ? 0 : 1, after.start_corner(t, i))).norm());
      for (int s = 0; s < 3; ++s) {
        if (after.neighbour(t, s) < t || after.chart_join(t, s).same_chart) continue;
        ++seams;
        CHECK(after.chart_join(t, s).stretch == relative(1.0).epsilon(1e-9));
        length += (after.start_corner(t, (s + 1) % 3) - after.start_corner(t, (s + 2) % 3)).norm();
        CHECK(after.start_corner(t, (s + 1) % 3)[0] == relative(0.5).epsilon(1e-12));
      }
    }
    CHECK(worst < 1e-12);
    CHECK(length == relative(1.0).epsilon(1e-12));
    CHECK(static_cast<double>(seams) > 0.6 / h);
    CHECK(static_cast<double>(seams) < 1.6 / h + 3);
    m = after;
  }
}

TEST_CASE("a refined cylinder is rounder than the mesh it began with, and stays so") {
  for (const Pattern pattern : {Pattern::diagonal, Pattern::union_jack}) {
    mesh::SurfaceMesh m(mapped(square(pattern, 12), on_cylinder));
    const RestSurface rest(m);
    REQUIRE(rest.curved());
    const double sagitta = 1.0 - std::cos(pi / 24), area_before = pi - total_area(m);
    for (const double h : {0.08, 0.04, 0.06}) {
      const Remeshed r = remeshed(m, rest, uniform(m, h));
      const mesh::SurfaceMesh after(r.mesh);
      check_result(m, r, after);
      CAPTURE(h);
      CAPTURE(radius_error(after) / sagitta);
      CHECK(radius_error(after) < 0.05 * sagitta);
      CHECK(std::abs(pi - total_area(after)) < (h < 0.07 ? 0.1 : 0.25) * area_before);
      CHECK(r.quality.smallest_angle > 20 * pi / 180);
      // The ends lie in their planes, the sides on their lines.
      for (Index v : after.group("bottom").vertices) CHECK(std::abs(after.positions()[v][2]) < 1e-12);
      for (Index v : after.group("left").vertices)
        CHECK((after.positions()[v] - Vec3(1, 0, after.positions()[v][2])).norm() < 1e-12);
      CHECK(group_length(after, "bottom") > group_length(m, "bottom") * (h < 0.05 ? 1.0 : 0.999));
      m = after;
    }
  }
}

TEST_CASE("a flat disc becomes rounder along its edge, and its area tends to the circle's") {
  mesh::MeshData d;
  const int n = 16;
  d.positions.push_back({0, 0, 0});
  for (int i = 0; i < n; ++i) d.positions.push_back({std::cos(2 * pi * i / n), std::sin(2 * pi * i / n), 0});
  for (Index i = 0; i < n; ++i) d.triangles.push_back({0, 1 + i, 1 + (i + 1) % n});
  mesh::SurfaceMesh m(d);
  const RestSurface rest(m);
  CHECK_FALSE(rest.curved());
  const double before = pi - total_area(m);
  for (const double h : {0.1, 0.05, 0.09, 0.6}) {
    m = mesh::SurfaceMesh(remeshed(m, rest, uniform(m, h)).mesh);
    double worst = 0.0;
    for (Index t = 0; t < m.triangle_count(); ++t)
      for (int s = 0; s < 3; ++s)
        if (m.neighbour(t, s) == no_index)
          worst = std::max(worst, std::abs(m.start_corner(t, (s + 1) % 3).norm() - 1.0));
    CHECK(worst < 2e-4);
    CHECK(std::abs(pi - total_area(m)) < 0.12 * before);
  }
}

TEST_CASE("a panel with a curved edge is not strained by a mesh that is rounder, wherever it lies") {
  const int n = 16;
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  mesh::MeshData d;
  d.positions.push_back({0, 0, 0});
  for (int i = 0; i < n; ++i) d.positions.push_back({std::cos(2 * pi * i / n), std::sin(2 * pi * i / n), 0});
  for (Index i = 0; i < n; ++i) {
    d.triangles.push_back({0, 1 + i, 1 + (i + 1) % n});
    d.rest.push_back({d.positions[0], d.positions[1 + i], d.positions[1 + (i + 1) % n]});
  }
  for (Vec3& x : d.positions) x = turn * x + Vec3(0.1, 0.2, 0.3);
  mesh::SurfaceMesh m(d);
  const RestSurface rest(m);
  REQUIRE(m.has_charts());
  for (const double h : {0.1, 0.05, 0.09, 0.6}) {
    m = mesh::SurfaceMesh(remeshed(m, rest, uniform(m, h)).mesh);
    double worst = 0.0, round = 0.0;
    for (Index t = 0; t < m.triangle_count(); ++t)
      for (int i = 0; i < 3; ++i) {
        worst = std::max(worst, (m.start_corner(t, i) - turn * m.rest_corner(t, i) - Vec3(0.1, 0.2, 0.3)).norm());
        round = std::max(round, m.rest_corner(t, i).norm());
      }
    CHECK(worst < 1e-12);
    CHECK(round < 1.0 + 2e-4);
  }
}

TEST_CASE("a crease stays an edge, with its place") {
  // A gutter: three planes that meet at 90 degrees.
  const auto gutter = [](const Vec3& x) {
    const double s = 3 * x[0];
    return s < 1 ? Vec3(0, x[1], 1 - s) : s < 2 ? Vec3(s - 1, x[1], 0) : Vec3(1, x[1], s - 2);
  };
  mesh::SurfaceMesh m(mapped(square(Pattern::diagonal, 12), gutter));
  const RestSurface rest(m);
  for (const double h : {0.05, 0.3}) {
    const Remeshed r = remeshed(m, rest, uniform(m, h));
    m = mesh::SurfaceMesh(r.mesh);
    CHECK(total_area(m) == relative(3.0).epsilon(1e-12));
    double length = 0.0;
    for (Index t = 0; t < m.triangle_count(); ++t)
      for (int s = 0; s < 3; ++s) {
        const Index other = m.neighbour(t, s);
        if (other < t || m.rest_normal(t).dot(m.rest_normal(other)) > 0.9) continue;
        CHECK(std::abs(m.rest_normal(t).dot(m.rest_normal(other))) < 1e-9);
        length += m.rest_length({m.triangles()[t][(s + 1) % 3], m.triangles()[t][(s + 2) % 3]});
      }
    CHECK(length == relative(2.0).epsilon(1e-12));
  }
}

TEST_CASE("operations move the surface in space no farther than contact allows") {
  const mesh::SurfaceMesh m(square(Pattern::jittered, 12));
  const RestSurface rest(m);
  std::vector<Vec3> places;
  for (const Vec3& x : m.positions()) places.emplace_back(x[0], x[1], 0.08 * std::sin(9 * x[0] + 2 * x[1]));
  const auto h = sizes(m, [](const Vec3& x) { return 0.05 + 0.2 * x[1]; });
  Index last = 0;
  for (const double clearance : {0.0, 1e-4, 2e-3, 1e9}) {
    Limits limits;
    limits.clearance.assign(static_cast<std::size_t>(m.vertex_count()), clearance);
    const Remeshed r = adapt::remesh(m, rest, places, h, limits, {});
    const mesh::SurfaceMesh after(r.mesh);
    const double moved = sampled_distance(m, places, after, r.places, 40);
    CAPTURE(clearance);
    CAPTURE(moved);
    CHECK(moved <= clearance + 1e-15);
    const Index changes = r.counts.collapses + r.counts.flips + r.counts.smoothed;
    CHECK(changes >= last);
    if (clearance == 1e9) {
      CHECK(moved > 2e-3);  // so the limits were felt
      CHECK(r.counts.refused_by_clearance == 0);
    } else {
      CHECK(r.counts.refused_by_clearance > 0);
    }
    REQUIRE(r.clearance.size() == r.kept.size());
    for (std::size_t v = 0; v < r.kept.size(); ++v) {
      CHECK((r.clearance[v] >= 0.0 && r.clearance[v] <= clearance));
      // What has been used up covers what the vertex has moved, in all operations together.
      const mesh::Triangle& t = m.triangles()[r.source[v].triangle];
      Vec3 was = Vec3::Zero();
      for (std::size_t i = 0; i < 3; ++i) was += r.source[v].weights[i] * places[t[i]];
      CHECK((r.places[v] - was).norm() <= clearance - r.clearance[v] + 1e-12 + 1e-7 * (clearance > 1.0));
    }
    last = changes;
  }
  // Only one half is in contact: the other half is as free as without.
  Limits half;
  for (const Vec3& x : m.positions()) half.clearance.push_back(x[0] < 0.5 ? 0.0 : INFINITY);
  const Remeshed r = adapt::remesh(m, rest, places, h, half, {});
  CHECK(r.counts.refused_by_clearance > 0);
  CHECK(r.counts.collapses > 0);
}

TEST_CASE(
    "what is curved and not strained stays so where contact leaves room, and moves no farther where it does not") {
  const Mat3 turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  const Vec3 shift(0.3, -0.2, 0.1);
  const auto disc = [](const Vec3& x) -> Vec3 {
    const double a = 2 * x[0] - 1, b = 2 * x[1] - 1;
    return {a * std::sqrt(1 - 0.5 * b * b), b * std::sqrt(1 - 0.5 * a * a), 0};
  };
  for (const auto& shape : {+disc, &on_cylinder}) {
    const int cells = shape == on_cylinder ? 8 : 6;
    const mesh::SurfaceMesh m(mapped(square(Pattern::jittered, cells), shape));
    std::vector<Vec3> places;
    for (const Vec3& x : m.positions()) places.emplace_back(turn * x + shift);
    for (const double clearance : {0.2, 1e-3}) {
      Limits limits;
      limits.clearance.assign(static_cast<std::size_t>(m.vertex_count()), clearance);
      const Remeshed r = adapt::remesh(m, RestSurface(m), places, uniform(m, 0.12), limits, {});
      const mesh::SurfaceMesh after(r.mesh);
      double strained = 0.0, moved = 0.0;
      for (std::size_t v = 0; v < r.places.size(); ++v) {
        double off = std::numeric_limits<double>::infinity();
        for (const mesh::Triangle& t : m.triangles())
          off =
              std::min(off, contact::point_triangle_distance({r.places[v], places[t[0]], places[t[1]], places[t[2]]}));
        strained = std::max(strained, (turn * after.positions()[v] + shift - r.places[v]).norm());
        moved = std::max(moved, off);
        CHECK(off <= clearance - r.clearance[v] + 1e-12);
      }
      CAPTURE(cells);
      CAPTURE(clearance);
      if (clearance < 0.2) continue;
      CHECK(moved > 1e-3);  // it went with the curve
      CHECK(strained < 1e-12);
    }
  }
}

TEST_CASE("folds in space are not turned") {
  // Folded sharply in space along the diagonal of two thin cells that rest flat: Delaunay would turn the diagonal.
  mesh::MeshData d;
  d.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, 0.15, 0}, {0.5, -0.15, 0}};
  d.triangles = {{0, 1, 2}, {1, 0, 3}};
  const mesh::SurfaceMesh m(d);
  const RestSurface rest(m);
  std::vector<Vec3> folded = m.positions();
  folded[2] = Vec3(0.5, 0, 0.15);
  CHECK(remeshed(m, rest, uniform(m, 1.0)).counts.flips == 1);
  CHECK(adapt::remesh(m, rest, folded, uniform(m, 1.0), {}, {}).counts.flips == 0);
}

TEST_CASE("a narrow sleeve stays one, however coarse it is wanted") {
  // Five cells round, sewn to itself; flat at rest. Around it every two vertices have others than their triangles in common.
  const int n = 5, rows = 12;
  mesh::MeshData d;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i < n; ++i) d.positions.emplace_back(std::cos(2 * pi * i / n), std::sin(2 * pi * i / n), 0.3 * j);
  const auto add = [&](std::array<int, 6> ij) {
    d.triangles.push_back({ij[1] * n + ij[0] % n, ij[3] * n + ij[2] % n, ij[5] * n + ij[4] % n});
    d.rest.push_back({Vec3(ij[0], ij[1], 0), Vec3(ij[2], ij[3], 0), Vec3(ij[4], ij[5], 0)});
  };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < n; ++i) {
      add({i, j, i + 1, j, i + 1, j + 1});
      add({i, j, i + 1, j + 1, i, j + 1});
    }
  const mesh::SurfaceMesh m(d);
  const RestSurface rest(m);
  const Remeshed r = remeshed(m, rest, uniform(m, 40.0));
  CHECK(r.counts.collapses > 10);
  const mesh::SurfaceMesh after(r.mesh);
  CHECK(euler(after) == 0);
  CHECK(total_area(after) == relative(n * rows).epsilon(1e-12));
}

TEST_CASE("new vertices of a concave boundary are points of the old boundary") {
  const mesh::SurfaceMesh m(mapped(grid(32, 6, false, 0.0), [](const Vec3& x) {
    const double r = 1 + x[1];
    return Vec3(r * std::cos(pi * x[0]), r * std::sin(pi * x[0]), 0);
  }));
  const RestSurface rest(m);
  const Remeshed r = remeshed(m, rest, uniform(m, 0.03));
  const mesh::SurfaceMesh after(r.mesh);
  Index seen = 0;
  for (Index t = 0; t < after.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      const Index v = after.triangles()[t][(s + 1) % 3];
      if (after.neighbour(t, s) != no_index || r.kept[v] != no_index) continue;
      const auto& at = r.source[v];
      bool on_side = false;
      for (int k = 0; k < 3; ++k)
        on_side =
            on_side || (m.neighbour(at.triangle, k) == no_index && at.weights[static_cast<std::size_t>(k)] == 0.0);
      CHECK(on_side);
      ++seen;
    }
  CHECK(seen > 150);
}

}  // namespace test_adapt_rest

#include "islands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

/// Change of direction at which a rim has a corner [rad]: more than that of round edges of coarse meshes.
constexpr double island_corner = 30.0 * std::numbers::pi / 180.0;

/// Of a piece, as a fraction of its extent squared.
constexpr double least_area = 1e-6;

}  // namespace

void DrawnMesh::fail(Index triangle, const Vec2& place, const char* what, const char* remedy) const {
  throw UserError(fmt::format("{}: face {}: in texture coordinates (vt) {} near ({:.4g}, {:.4g}); {}", file_,
                              mesh_.triangle_tags[static_cast<std::size_t>(triangle)], what, place[0] / unit_,
                              place[1] / unit_, remedy));
}

/// Whether two sides of triangles are one edge in the plane too. `b` runs the other way, or the same way on a surface whose
/// faces are not oriented alike, which is found later.
bool DrawnMesh::joins(const Side& a, const Side& b) const {
  const Vec2 &a0 = texture(a.triangle, a.corner), &a1 = texture(a.triangle, a.corner + 1),
             &b0 = texture(b.triangle, b.corner), &b1 = texture(b.triangle, b.corner + 1);
  const bool is_against = triangle(a.triangle)[a.corner] == triangle(b.triangle)[(b.corner + 1) % 3];
  return is_against ? is_same(a0, b1) && is_same(a1, b0) : is_same(a0, b0) && is_same(a1, b1);
}

std::vector<Island> DrawnMesh::islands() const {
  std::vector<Island> islands;
  const auto count = static_cast<Index>(mesh_.triangles.size());
  std::map<mesh::Segment, std::vector<Side>> sides;
  for (Index t = 0; t < count; ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = triangle(t)[i], b = triangle(t)[(i + 1) % 3];
      sides[{std::min(a, b), std::max(a, b)}].push_back({t, i});
    }
  std::vector<Index> root(mesh_.triangles.size());
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index t) {
    while (root[t] != t) t = root[t] = root[root[t]];
    return t;
  };
  for (const auto& [edge, at] : sides)
    for (std::size_t i = 1; i < at.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (joins(at[j], at[i])) {
          const auto [low, high] = std::minmax({find(at[j].triangle), find(at[i].triangle)});
          root[high] = low;
        }
  std::map<Index, std::size_t> number;
  for (Index t = 0; t < count; ++t) {
    const auto [at, is_new] = number.insert({find(t), islands.size()});
    if (is_new) islands.emplace_back();
    islands[at->second].triangles.push_back(t);
  }
  for (Island& island : islands) {
    add_points(island);
    orient(island);
  }
  return islands;
}

/// A vertex on a seam of a piece with itself has several points.
void DrawnMesh::add_points(Island& island) const {
  std::map<Index, std::vector<Index>> points_of;
  for (const Index t : island.triangles) {
    mesh::Triangle& corners = island.corners.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      std::vector<Index>& known = points_of[triangle(t)[i]];
      const auto is_it = [&](Index p) { return is_same(island.points[static_cast<std::size_t>(p)], texture(t, i)); };
      const auto at = std::find_if(known.begin(), known.end(), is_it);
      corners[i] = at == known.end() ? static_cast<Index>(island.points.size()) : *at;
      if (at != known.end()) continue;
      known.push_back(corners[i]);
      island.vertices.push_back(triangle(t)[i]);
      island.points.push_back(texture(t, i));
    }
  }
}

void DrawnMesh::orient(Island& island) const {
  double whole = 0.0, sum = 0.0;
  std::vector<double> areas;
  for (const mesh::Triangle& t : island.corners) {
    const auto x = [&](std::size_t i) { return island.points[static_cast<std::size_t>(t[i])]; };
    const Vec2 a = x(1) - x(0), b = x(2) - x(0);
    areas.push_back(0.5 * (a[0] * b[1] - a[1] * b[0]));
    whole += areas.back();
    sum += std::abs(areas.back());
  }
  double extent = 0.0;
  for (const Vec2& x : island.points) extent = std::max(extent, (x - island.points.front()).norm());
  if (!(sum > least_area * extent * extent))
    fail(island.triangles.front(), island.points.front(), "the piece has no area", "correct them, or remove it");
  island.is_turned = whole < 0.0;
  const double small = 1e-6 * sum / static_cast<double>(areas.size());
  for (std::size_t k = 0; k < areas.size(); ++k)
    if ((island.is_turned ? -areas[k] : areas[k]) < -small)
      fail(island.triangles[k], texture(island.triangles[k], 0), "the piece folds over",
           "correct them, or orient all faces alike");
}

/// Where the rim of an island continues from each point of it.
std::map<Index, Index> DrawnMesh::rim_steps(const Island& island) const {
  std::map<mesh::Segment, int> count;
  for (const mesh::Triangle& t : island.corners)
    for (std::size_t i = 0; i < 3; ++i) ++count[{t[i], t[(i + 1) % 3]}];
  std::map<Index, Index> next;
  for (std::size_t k = 0; k < island.corners.size(); ++k)
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = island.corners[k][i], b = island.corners[k][(i + 1) % 3];
      if (count[{a, b}] > 1 || (!count.contains({b, a}) && !next.insert({a, b}).second))
        fail(island.triangles[k], island.points[static_cast<std::size_t>(a)], "the piece overlaps or touches itself",
             "give each part of it its own coordinates");
    }
  return next;
}

std::vector<Rim> DrawnMesh::rims(const std::vector<Island>& islands) const {
  std::vector<Rim> all;
  for (std::size_t k = 0; k < islands.size(); ++k) {
    std::map<Index, Index> next = rim_steps(islands[k]);
    if (next.empty())
      fail(islands[k].triangles.front(), islands[k].points.front(), "the piece has no rim", "cut it open along a seam");
    while (!next.empty()) {
      std::vector<Index> way;
      for (auto at = next.begin(); at != next.end(); at = next.find(way.back())) {
        way.push_back(at->second);
        next.erase(at);
      }
      all.push_back(rim_of(k, islands[k], std::move(way)));
    }
  }
  return all;
}

/// Begins at a corner, if there is one.
Rim DrawnMesh::rim_of(std::size_t k, const Island& island, std::vector<Index> way) const {
  const std::size_t n = way.size();
  const auto point = [&](std::size_t i) { return island.points[static_cast<std::size_t>(way[i % n])]; };
  const auto is_corner = [&](std::size_t i) {
    const Vec2 d = point(i) - point(i + n - 1), e = point(i + 1) - point(i);
    return std::abs(std::atan2(d[0] * e[1] - d[1] * e[0], d.dot(e))) > island_corner;
  };
  std::size_t first = 0;
  while (first < n && !is_corner(first)) ++first;
  if (first < n) std::rotate(way.begin(), way.begin() + static_cast<std::ptrdiff_t>(first), way.end());
  Rim rim{k, {}, {}, {0.0}, {}};
  for (std::size_t i = 0; i < n; ++i) {
    rim.vertices.push_back(island.vertices[static_cast<std::size_t>(way[i])]);
    rim.points.push_back(point(i));
    rim.s.push_back(rim.s.back() + (point(i + 1) - point(i)).norm());
    if (i == 0 || is_corner(i)) rim.breaks.push_back(rim.s[i]);
  }
  if (rim.breaks.size() == 1) rim.breaks.push_back(rim.s[n / 2]);
  rim.breaks.push_back(rim.s.back());
  return rim;
}

}  // namespace voile::pattern

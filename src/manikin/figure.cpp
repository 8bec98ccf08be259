#include "figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "geometry/implicit_surface.hpp"
#include "geometry/intersections.hpp"
#include "geometry/winding.hpp"
#include "voile/errors.hpp"

namespace voile::manikin {

namespace {

/// Loops of the section of a closed surface at a height, which no vertex has.
std::vector<std::vector<Vec2>> section(const geometry::TriangleSoup& surface, double z) {
  using Edge = std::pair<Index, Index>;
  std::map<Edge, Edge> next;  // from the edge through which a triangle is entered to the one through which it is left
  const auto above = [&](Index v) { return surface.positions[v].z() > z; };
  const auto edge = [](Index a, Index b) { return Edge(std::min(a, b), std::max(a, b)); };
  for (const mesh::Triangle& t : surface.triangles) {
    Edge from, to;
    bool cut = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = t[i], b = t[(i + 1) % 3];
      if (above(a) == above(b)) continue;
      cut = true;
      (above(a) ? from : to) = edge(a, b);
    }
    if (cut) next[from] = to;
  }
  std::vector<std::vector<Vec2>> loops;
  while (!next.empty()) {
    std::vector<Vec2>& loop = loops.emplace_back();
    for (auto at = next.begin(); at != next.end();) {
      const Vec3 &a = surface.positions[at->first.first], &b = surface.positions[at->first.second];
      loop.emplace_back((a + (z - a.z()) / (b.z() - a.z()) * (b - a)).head<2>());
      const Edge to = at->second;
      next.erase(at);
      at = next.find(to);
    }
  }
  return loops;
}

bool winds_around_origin(const std::vector<Vec2>& loop) {
  double angle = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    angle += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return std::abs(angle) > 3.0;
}

/// 2 for a sphere, per piece.
Index euler_number(const geometry::TriangleSoup& s) {
  std::set<std::pair<Index, Index>> edges;
  for (const mesh::Triangle& t : s.triangles)
    for (std::size_t i = 0; i < 3; ++i) edges.emplace(std::minmax({t[i], t[(i + 1) % 3]}));
  return static_cast<Index>(s.positions.size()) - static_cast<Index>(edges.size()) +
         static_cast<Index>(s.triangles.size());
}

Index piece_count(const geometry::TriangleSoup& s) {
  std::vector<Index> parent(s.positions.size());
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = static_cast<Index>(v);
  const auto root = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const mesh::Triangle& t : s.triangles)
    for (std::size_t i = 0; i < 2; ++i) parent[root(t[i])] = root(t[i + 1]);
  Index count = 0;
  for (std::size_t v = 0; v < parent.size(); ++v) count += root(static_cast<Index>(v)) == static_cast<Index>(v);
  return count;
}

/// A triangle's corners lie on the shape and its middle inside: the trunk is widened by the little that is missing.
void adjust(const Shape& shape, geometry::TriangleSoup& surface) {
  const Measurements& m = shape.measurements();
  const Levels& l = shape.levels();
  const std::array heights{l.crotch, l.hip, l.waist, l.bust, l.armpit};
  const std::array at{l.hip, l.waist, l.bust}, asked{m.hip, m.waist, m.bust};
  for (int round = 0; round < 3; ++round) {
    std::array scale{1.0, 1.0, 1.0, 1.0, 1.0};
    for (std::size_t k = 0; k < 3; ++k) scale[k + 1] = asked[k] / tape_girth(surface, at[k]);
    for (Vec3& p : surface.positions) {
      if (p.z() <= heights.front() || p.z() >= heights.back()) continue;
      if (shape.kind() == Kind::figure && shape.arm(p) < shape.body(p)) continue;
      std::size_t k = 0;
      while (p.z() > heights[k + 1]) ++k;
      const double t = (p.z() - heights[k]) / (heights[k + 1] - heights[k]), s = t * t * (3.0 - 2.0 * t);
      p.head<2>() *= (1.0 - s) * scale[k] + s * scale[k + 1];
    }
  }
}

}  // namespace

double tape_girth(const geometry::TriangleSoup& surface, double z) {
  for (const Vec3& p : surface.positions)
    if (p.z() == z) return tape_girth(surface, z + 1e-9);
  double longest = 0.0;
  for (std::vector<Vec2>& loop : section(surface, z))
    if (winds_around_origin(loop)) longest = std::max(longest, hull_perimeter(std::move(loop)));
  return longest;
}

Figure make_figure(const Measurements& m, Kind kind, double size) {
  if (!(size >= 0.005 && size <= 0.06)) throw UserError(fmt::format("size = {:g} m is outside 0.005 to 0.06 m", size));
  Figure figure{Shape::tuned(m, kind), {}, {}};
  const Levels& l = figure.shape.levels();
  geometry::ImplicitMeshing how;
  how.centre = Vec3(0.0, 0.0, l.waist);
  how.radius = 1.2 * m.height;
  how.size = size;
  how.deviation = 0.06 * size;
  figure.surface = geometry::implicit_surface([&](const Vec3& p) { return figure.shape(p); }, how);
  geometry::TriangleSoup& s = figure.surface;
  adjust(figure.shape, s);
  figure.girths = {tape_girth(s, l.bust), tape_girth(s, l.waist), tape_girth(s, l.hip)};
  const char* wrong = nullptr;
  if (!geometry::is_closed(s.triangles)) wrong = "is not closed";
  if (piece_count(s) != 1 || euler_number(s) != 2) wrong = "has limbs that touch or come off";
  if (!geometry::intersecting_triangles(s.positions, s.triangles).empty()) wrong = "intersects itself";
  const auto off = [](double is, double asked) { return std::abs(is - asked) > 0.005 * asked; };
  if (off(figure.girths.bust, m.bust) || off(figure.girths.waist, m.waist) || off(figure.girths.hip, m.hip))
    wrong = "does not have their girths, because bust or waist is too wide for its shoulders";
  if (wrong)
    throw UserError(fmt::format(
        "the surface of these measurements {}: choose others, a wider angle of the arms or a smaller size", wrong));
  return figure;
}

}  // namespace voile::manikin

#include "intersections.hpp"

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>
#include <CGAL/version.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <variant>

#include "voile/errors.hpp"

namespace voile::geometry {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Segment = Kernel::Segment_3;
using Face = Kernel::Triangle_3;
using Shape = std::variant<Point, Segment, Face>;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, Index>;

/// So many boxes are scanned one after the other and divided no further.
constexpr std::ptrdiff_t most_scanned = 200;

/// The convex hull of two points.
Shape hull(const Point& a, const Point& b) {
  if (a == b) return a;
  return Segment(a, b);
}

/// The convex hull of three points.
Shape hull(const Point& a, const Point& b, const Point& c) {
  if (!CGAL::collinear(a, b, c)) return Face(a, b, c);
  const auto [low, high] = std::minmax({a, b, c});  // lexicographic order is an order along the line
  return hull(low, high);
}

bool meet(const Shape& one, const Shape& other) {
  return std::visit([](const auto& a, const auto& b) { return CGAL::do_intersect(a, b); }, one, other);
}

class Surface {
 public:
  Surface(const std::vector<Vec3>& positions, const std::vector<mesh::Triangle>& triangles) : triangles_(triangles) {
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const Vec3& x = positions[v];
      if (!x.allFinite())
        throw InternalError(fmt::format("check of intersections: the position of vertex {} is not finite", v));
      points_.emplace_back(x[0], x[1], x[2]);
    }
    shapes_.resize(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (const Index v : triangles[t])
        if (v < 0 || static_cast<std::size_t>(v) >= points_.size())
          throw InternalError(fmt::format("check of intersections: triangle {} names vertex {}, but there are {}", t, v,
                                          points_.size()));
  }

  [[nodiscard]] std::vector<Box> boxes() const {
    std::vector<Box> result;
    result.reserve(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const auto& [a, b, c] = triangles_[t];
      result.emplace_back(at(a).bbox() + at(b).bbox() + at(c).bbox(), static_cast<Index>(t));
    }
    return result;
  }

  [[nodiscard]] bool intersect(Index i, Index j) const {
    const mesh::Triangle &one = triangle(i), &other = triangle(j);
    std::array<Index, 3> common{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (contains(other, one[k]) && std::find(one.begin(), one.begin() + k, one[k]) == one.begin() + k)
        common[count++] = one[k];
    switch (count) {
      case 0:
        return meet(shape(i), shape(j));
      case 1:
        return leaves_inside(i, j, common[0]) || leaves_inside(j, i, common[0]);
      case 2:
        return folded(i, j, common[0], common[1]);
      default:
        return true;
    }
  }

 private:
  [[nodiscard]] const Point& at(Index v) const { return points_[static_cast<std::size_t>(v)]; }
  /// Made when first asked for, which it is of few.
  [[nodiscard]] const Shape& shape(Index t) const {
    std::optional<Shape>& s = shapes_[static_cast<std::size_t>(t)];
    const auto& [a, b, c] = triangle(t);
    if (!s) s = hull(at(a), at(b), at(c));
    return *s;
  }
  [[nodiscard]] const mesh::Triangle& triangle(Index t) const { return triangles_[static_cast<std::size_t>(t)]; }
  [[nodiscard]] static bool contains(const mesh::Triangle& t, Index v) {
    return std::find(t.begin(), t.end(), v) != t.end();
  }

  /// A way out of triangle i, seen from its vertex v, is in triangle j: a point of the edge opposite to v, or, if
  /// triangle i is but a segment, one of its corners away from v.
  [[nodiscard]] bool leaves_inside(Index i, Index j, Index v) const {
    const mesh::Triangle& t = triangle(i);
    if (std::holds_alternative<Face>(shape(i))) {
      const auto k = static_cast<std::size_t>(std::find(t.begin(), t.end(), v) - t.begin());
      return meet(Segment(at(t[(k + 1) % 3]), at(t[(k + 2) % 3])), shape(j));
    }
    return std::any_of(t.begin(), t.end(), [&](Index w) { return at(w) != at(v) && meet(at(w), shape(j)); });
  }

  /// Triangles with the edge a b lie on each other.
  [[nodiscard]] bool folded(Index i, Index j, Index a, Index b) const {
    if (!std::holds_alternative<Face>(shape(i)) || !std::holds_alternative<Face>(shape(j))) return false;
    const auto apex = [&](const mesh::Triangle& t) -> const Point& {
      return at(*std::find_if(t.begin(), t.end(), [&](Index v) { return v != a && v != b; }));
    };
    const Point &p = apex(triangle(i)), &q = apex(triangle(j));
    return CGAL::coplanar(at(a), at(b), p, q) && CGAL::coplanar_orientation(at(a), at(b), p, q) == CGAL::POSITIVE;
  }

  const std::vector<mesh::Triangle>& triangles_;
  std::vector<Point> points_;
  mutable std::vector<std::optional<Shape>> shapes_;
};

/// What one of several has to look at: pairs whose boxes begin to overlap, along one axis, in its interval.
struct Slab {
  int axis = 0;
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();

  /// About as many of the boxes for each part, along the axis in which they reach farthest.
  Slab(std::vector<Box>::const_iterator first, std::vector<Box>::const_iterator last, Share fraction) {
    if (fraction.parts == 1 || first == last) return;
    CGAL::Bbox_3 all;
    std::for_each(first, last, [&](const Box& b) { all += b.bbox(); });
    for (int k = 1; k < 3; ++k)
      if (all.max(k) - all.min(k) > all.max(axis) - all.min(axis)) axis = k;
    std::vector<double> begins;
    std::transform(first, last, std::back_inserter(begins), [&](const Box& b) { return b.min_coord(axis); });
    const auto bound = [&](int part) {
      const auto at = begins.begin() + static_cast<std::ptrdiff_t>(begins.size() * static_cast<std::size_t>(part) /
                                                                   static_cast<std::size_t>(fraction.parts));
      std::nth_element(begins.begin(), at, begins.end());
      return *at;
    };
    if (fraction.part > 0) low = bound(fraction.part);
    if (fraction.part + 1 < fraction.parts) high = bound(fraction.part + 1);
  }
  [[nodiscard]] bool meets(const Box& b) const { return b.max_coord(axis) >= low && b.min_coord(axis) < high; }
  /// Of two that meet the slab; their begins are below `high`.
  [[nodiscard]] bool has(const Box& a, const Box& b) const {
    return std::max(a.min_coord(axis), b.min_coord(axis)) >= low;
  }
};

/// `is_idle(triangle)`: of a set of which no two are wanted, as the triangles of obstacles are: most of a scene, and
/// they need not be tried against each other.
template <class Wanted, class Idle>
std::vector<TrianglePair> find_pairs(const std::vector<Vec3>& positions, const std::vector<mesh::Triangle>& triangles,
                                     const Wanted& is_wanted, const Idle& is_idle, Share fraction) {
  const Surface surface(positions, triangles);
  std::vector<Box> boxes = surface.boxes();
  const auto all_busy = std::partition(boxes.begin(), boxes.end(), [&](const Box& b) { return !is_idle(b.info()); });
  const Slab slab(boxes.begin(), all_busy, fraction);
  const auto busy = std::partition(boxes.begin(), all_busy, [&](const Box& b) { return slab.meets(b); });
  CGAL::Bbox_3 near;
  std::for_each(boxes.begin(), busy, [&](const Box& b) { near += b.bbox(); });
  const auto idle =
      std::partition(all_busy, boxes.end(), [&](const Box& b) { return CGAL::do_overlap(b.bbox(), near); });
  std::vector<TrianglePair> pairs;
  const auto note = [&](const Box& a, const Box& b) {
    const auto [i, j] = std::minmax({a.info(), b.info()});
    if (slab.has(a, b) && is_wanted(i, j) && surface.intersect(i, j)) pairs.emplace_back(i, j);
  };
  CGAL::box_intersection_d(boxes.begin(), busy, all_busy, idle, note, most_scanned);
  CGAL::box_self_intersection_d(boxes.begin(), busy, note, most_scanned);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

/// Bodies that are wanted neither with themselves nor with each other; none if that is not so of all that are not wanted
/// with themselves.
std::set<Index> idle_bodies(const std::vector<Index>& body, const std::function<bool(Index, Index)>& skip) {
  std::set<Index> idle(body.begin(), body.end());
  std::erase_if(idle, [&](Index b) { return !skip(b, b); });
  for (const Index a : idle)
    for (const Index b : idle)
      if (!skip(a, b)) return {};
  return idle;
}

void write_field(std::ofstream& out, const char* name, const std::vector<Index>& values) {
  out << fmt::format("{} 1 {} int\n", name, values.size());
  for (const Index value : values) out << value << '\n';
}

}  // namespace

std::vector<TrianglePair> intersecting_triangles(const std::vector<Vec3>& positions,
                                                 const std::vector<mesh::Triangle>& triangles) {
  return find_pairs(
      positions, triangles, [](Index, Index) { return true; }, [](Index) { return false; }, {});
}

std::vector<TrianglePair> intersecting_triangles(const std::vector<Vec3>& positions,
                                                 const std::vector<mesh::Triangle>& triangles,
                                                 const std::vector<Index>& body,
                                                 const std::function<bool(Index, Index)>& skip, Share fraction) {
  if (body.size() != triangles.size())
    throw InternalError(
        fmt::format("check of intersections: {} body numbers for {} triangles", body.size(), triangles.size()));
  const std::set<Index> idle = idle_bodies(body, skip);
  std::vector<char> is_idle;
  std::transform(body.begin(), body.end(), std::back_inserter(is_idle), [&](Index b) { return idle.contains(b); });
  return find_pairs(
      positions, triangles,
      [&](Index i, Index j) { return !skip(body[static_cast<std::size_t>(i)], body[static_cast<std::size_t>(j)]); },
      [&](Index t) { return is_idle[static_cast<std::size_t>(t)]; }, fraction);
}

void write_pairs(const std::filesystem::path& file, const std::vector<Vec3>& positions,
                 const std::vector<mesh::Triangle>& triangles, const std::vector<Index>& body,
                 const std::vector<TrianglePair>& pairs) {
  if (!body.empty() && body.size() != triangles.size())
    throw InternalError(
        fmt::format("{}: {} body numbers for {} triangles", file.string(), body.size(), triangles.size()));
  std::vector<Index> pair_field, triangle_field, body_field;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    for (const Index t : {pairs[k].first, pairs[k].second}) {
      if (t < 0 || static_cast<std::size_t>(t) >= triangles.size())
        throw InternalError(fmt::format("{}: there is no triangle {}", file.string(), t));
      pair_field.push_back(static_cast<Index>(k));
      triangle_field.push_back(t);
      body_field.push_back(body.empty() ? 0 : body[static_cast<std::size_t>(t)]);
    }
  std::ofstream out(file);
  const std::size_t cells = triangle_field.size();
  out << "# vtk DataFile Version 3.0\nintersecting triangles\nASCII\nDATASET POLYDATA\n";
  out << fmt::format("POINTS {} double\n", 3 * cells);
  for (const Index t : triangle_field)
    for (const Index v : triangles[static_cast<std::size_t>(t)]) {
      const Vec3& x = positions.at(static_cast<std::size_t>(v));
      out << fmt::format("{} {} {}\n", x[0], x[1], x[2]);
    }
  out << fmt::format("POLYGONS {} {}\n", cells, 4 * cells);
  for (std::size_t c = 0; c < cells; ++c) out << fmt::format("3 {} {} {}\n", 3 * c, 3 * c + 1, 3 * c + 2);
  out << fmt::format("CELL_DATA {}\nFIELD fields 3\n", cells);
  write_field(out, "pair", pair_field);
  write_field(out, "triangle", triangle_field);
  write_field(out, "body", body_field);
  out.close();
  if (!out)
    throw UserError(fmt::format("{}: the file cannot be written; check the folder and the disk", file.string()));
}

std::string cgal_version() {
  return CGAL_STR(CGAL_VERSION);
}

}  // namespace voile::geometry

#include "tie.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "mesh/coincident.hpp"
#include "mesh/sorted_points.hpp"
#include "tie_crossing.hpp"
#include "tie_points.hpp"
#include "tie_surface.hpp"
#include "triangle_division.hpp"
#include "voile/errors.hpp"

namespace voile::geometry {

namespace {

using mesh::Segment;

/// Where two segments are nearest to each other; parts of the way, not bounded.
struct Meeting {
  double first = 0.0, second = 0.0, distance = 0.0;
  bool parallel = false;
};

Meeting cross(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = d - c, w = c - a;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), det = uu * vv - uv * uv;
  Meeting x;
  x.parallel = det <= 1e-6 * uu * vv;
  if (x.parallel) return x;
  x.first = (vv * u.dot(w) - uv * v.dot(w)) / det;
  x.second = (uv * u.dot(w) - uu * v.dot(w)) / det;
  x.distance = (a + x.first * u - c - x.second * v).norm();
  return x;
}

class Tying {
 public:
  Tying(mesh::MeshData& data, double tolerance, const std::vector<Segment>& rims)
      : data_(data), tolerance_(tolerance), points_(data, tolerance), rim_(all_rims(data, rims)) {}

  Tied run(bool crossing) {
    const auto first = static_cast<Index>(data_.positions.size());
    find_vertices();
    find_crossings();
    if (crossing) crossing_ = crossing_triangles(data_, tolerance_, rim_);
    tied_.vertices += pierce(data_, crossing_, points_);
    find_new_vertices(first);
    points_.sort();
    divide();
    return tied_;
  }

 private:
  const Vec3& x(Index v) const { return data_.positions[v]; }

  /// Vertices of rims in triangles or on their sides, and all others on rims.
  void find_vertices() {
    std::set<Index> at_rim, hanging;
    for (const Segment& e : rim_) at_rim.insert(e.begin(), e.end());
    std::set<Index> all;
    for (const mesh::Triangle& t : data_.triangles) all.insert(t.begin(), t.end());
    const mesh::SortedPoints rims(data_.positions, {at_rim.begin(), at_rim.end()});
    for (std::size_t k = 0; k < data_.triangles.size(); ++k) {
      const mesh::Triangle& t = data_.triangles[k];
      const std::array<Vec3, 3> corners = corners_of(data_, static_cast<Index>(k));
      rims.each_near(corners, tolerance_, [&](Index v) {
        if (v == t[0] || v == t[1] || v == t[2] || distance_to_triangle(x(v), corners) > tolerance_) return;
        require_height(static_cast<Index>(k));
        points_.put_in(v, static_cast<Index>(k));
        hanging.insert(v);
      });
    }
    const mesh::SortedPoints anywhere(data_.positions, {all.begin(), all.end()});
    for (const Segment& e : rim_)
      anywhere.each_near(std::array{x(e[0]), x(e[1])}, tolerance_, [&](Index v) {
        if (v == e[0] || v == e[1] || distance_to_segment(x(v), x(e[0]), x(e[1])) > tolerance_) return;
        points_.put_on(v, e);
        hanging.insert(v);
      });
    tied_.vertices = static_cast<Index>(hanging.size());
  }

  void require_height(Index t) const {
    const std::array<Vec3, 3> c = corners_of(data_, t);
    const double longest = std::max({(c[1] - c[0]).norm(), (c[2] - c[1]).norm(), (c[0] - c[2]).norm()});
    if ((c[1] - c[0]).cross(c[2] - c[0]).norm() < 4.0 * tolerance_ * longest) fail(t);
  }

  [[noreturn]] void fail(Index t) const {
    const Vec3& p = x(data_.triangles[t][0]);
    throw UserError(fmt::format(
        "{}: mesh.merge: what ends on triangle {} at ({:.6g}, {:.6g}, {:.6g}) cannot be tied to it within {:.3g} m; "
        "make merge_tolerance smaller, or give both parts the same vertices there",
        data_.source, number_of(t), p[0], p[1], p[2], tolerance_));
  }

  /// New vertices where a rim crosses sides of triangles.
  void find_crossings() {
    const TieSurface s = surface_of(data_);
    std::vector<Vec3> middles;
    double longest = 0.0;
    std::vector<Index> numbers;
    for (const Segment& e : rim_) {
      numbers.push_back(static_cast<Index>(middles.size()));
      middles.push_back(0.5 * (x(e[0]) + x(e[1])));
      longest = std::max(longest, (x(e[0]) - x(e[1])).norm());
    }
    const mesh::SortedPoints sorted(middles, numbers);
    std::set<std::pair<Segment, Segment>> done;
    for (const auto& entry : s.around) {
      const Segment edge = entry.first;
      sorted.each_near(std::array{x(edge[0]), x(edge[1])}, 0.5 * longest + tolerance_, [&](Index k) {
        const Segment& rim = rim_[k];
        if (points_.is_on(rim[0], edge) || points_.is_on(rim[1], edge) || points_.is_on(edge[0], rim) ||
            points_.is_on(edge[1], rim))
          return;
        const Meeting c = cross(x(edge[0]), x(edge[1]), x(rim[0]), x(rim[1]));
        if (c.parallel || c.distance > tolerance_ ||
            !(c.first > 0.0 && c.first < 1.0 && c.second > 0.0 && c.second < 1.0))
          return;
        if (!done.insert(std::minmax(edge, rim)).second) return;
        const Index v = points_.vertex_at(x(edge[0]) + c.first * (x(edge[1]) - x(edge[0])), edge, rim);
        points_.put_on(v, edge);
        points_.put_on(v, rim);
      });
    }
  }

  /// Where three parts meet, a new vertex of two of them is in a triangle of the third.
  void find_new_vertices(Index first) {
    std::vector<Index> added;
    for (Index v = first; v < static_cast<Index>(data_.positions.size()); ++v) added.push_back(v);
    if (added.empty()) return;
    const mesh::SortedPoints sorted(data_.positions, added);
    for (std::size_t k = 0; k < data_.triangles.size(); ++k) {
      const std::array<Vec3, 3> corners = corners_of(data_, static_cast<Index>(k));
      sorted.each_near(corners, tolerance_, [&](Index v) {
        if (distance_to_triangle(x(v), corners) <= tolerance_) (void)points_.put_in(v, static_cast<Index>(k));
      });
    }
  }

  void divide() {
    const std::size_t count = data_.triangles.size();
    std::vector<Index> parent(count);
    for (std::size_t t = 0; t < count; ++t) parent[t] = static_cast<Index>(t);
    std::map<Index, std::set<Index>> pieces;  // of rims and crossings: what follows each vertex
    for (const Segment& e : rim_) {
      const std::vector<Index> points = points_.chain(e[0], e[1]);
      for (std::size_t i = 0; i + 1 < points.size(); ++i) pieces[points[i]].insert(points[i + 1]);
    }
    for (const Segment& line : lines_of(data_, crossing_, points_)) pieces[line[0]].insert(line[1]);
    std::set<Index> touched;
    for (std::size_t t = 0; t < count; ++t) divide(static_cast<Index>(t), pieces, parent, touched);
    tied_.triangles = static_cast<Index>(touched.size());
    update_groups(parent);
    const std::vector<Index> vertices = points_.all();
    improve_angles(data_, {vertices.begin(), vertices.end()}, tolerance_);
  }

  void divide(Index t, const std::map<Index, std::set<Index>>& pieces, std::vector<Index>& parent,
              std::set<Index>& touched) {
    const mesh::Triangle corners = data_.triangles[t];
    std::vector<Index> vertices, outline;
    std::vector<std::size_t> begins;
    for (std::size_t s = 0; s < 3; ++s) {
      std::vector<Index> side = points_.chain(corners[s], corners[(s + 1) % 3]);
      side.pop_back();
      begins.push_back(vertices.size());
      vertices.insert(vertices.end(), side.begin(), side.end());
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) outline.push_back(static_cast<Index>(i));
    vertices.insert(vertices.end(), points_.inside(t).begin(), points_.inside(t).end());
    if (vertices.size() == 3) return;
    std::map<Index, Index> local;
    for (std::size_t i = 0; i < vertices.size(); ++i) local[vertices[i]] = static_cast<Index>(i);
    std::vector<std::array<Index, 2>> lines;
    for (const auto& [v, i] : local) {
      const auto at = pieces.find(v);
      if (at == pieces.end()) continue;
      for (const Index w : at->second)
        if (const auto other = local.find(w); other != local.end() && !on_one_side(v, w, corners))
          lines.push_back({i, other->second});
    }
    const std::vector<Vec3> weights = weights_of(corners, vertices, begins);
    const std::vector<Corners> parts = divide_polygon(in_plane(corners, weights), outline, lines);
    if (parts.empty()) fail(t);
    touched.insert(t);
    replace(t, parts, vertices, weights, parent);
  }

  bool on_one_side(Index v, Index w, const mesh::Triangle& corners) const {
    for (std::size_t s = 0; s < 3; ++s) {
      const Segment edge = mesh::ascending(corners[s], corners[(s + 1) % 3]);
      if (points_.is_on(v, edge) && points_.is_on(w, edge)) return true;
    }
    return false;
  }

  /// Barycentric weights of points of a triangle; those of its sides exactly on them.
  std::vector<Vec3> weights_of(const mesh::Triangle& corners, const std::vector<Index>& vertices,
                               const std::vector<std::size_t>& begins) const {
    Eigen::Matrix<double, 3, 2> sides;
    sides << x(corners[1]) - x(corners[0]), x(corners[2]) - x(corners[0]);
    const Eigen::Matrix2d inverse = (sides.transpose() * sides).inverse();
    std::vector<Vec3> weights;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vec2 w = inverse * (sides.transpose() * (x(vertices[i]) - x(corners[0])));
      weights.emplace_back(1.0 - w[0] - w[1], w[0], w[1]);
    }
    for (std::size_t s = 0; s < 3; ++s) {
      const Index a = corners[s], b = corners[(s + 1) % 3];
      const std::size_t points = points_.chain(a, b).size() - 1;
      for (std::size_t i = begins[s]; i < begins[s] + points; ++i) {
        const double at = station(x(vertices[i]), x(a), x(b));
        weights[i].setZero();
        weights[i][static_cast<Eigen::Index>(s)] = 1.0 - at;
        weights[i][static_cast<Eigen::Index>((s + 1) % 3)] = at;
      }
    }
    return weights;
  }

  std::vector<Vec2> in_plane(const mesh::Triangle& corners, const std::vector<Vec3>& weights) const {
    const Vec3 u = x(corners[1]) - x(corners[0]), v = x(corners[2]) - x(corners[0]);
    const double length = u.norm(), along = v.dot(u) / length, height = u.cross(v).norm() / length;
    std::vector<Vec2> points;
    for (const Vec3& w : weights) points.emplace_back(w[1] * length + w[2] * along, w[2] * height);
    return points;
  }

  std::size_t number_of(Index t) const {
    return static_cast<std::size_t>(t) < data_.triangle_tags.size() ? data_.triangle_tags[t]
                                                                    : static_cast<std::size_t>(t) + 1;
  }

  /// The first part takes the triangle's place, the others follow at the end.
  void replace(Index t, const std::vector<Corners>& parts, const std::vector<Index>& vertices,
               const std::vector<Vec3>& weights, std::vector<Index>& parent) {
    const bool textured = !data_.texture.empty();
    const std::array<Vec2, 3> texture = textured ? data_.texture[t] : std::array<Vec2, 3>{};
    for (std::size_t k = 0; k < parts.size(); ++k) {
      mesh::Triangle part;
      std::array<Vec2, 3> coordinates;
      for (std::size_t i = 0; i < 3; ++i) {
        part[i] = vertices[parts[k][i]];
        const Vec3& w = weights[parts[k][i]];
        coordinates[i] = w[0] * texture[0] + w[1] * texture[1] + w[2] * texture[2];
      }
      if (k == 0) {
        data_.triangles[t] = part;
        if (textured) data_.texture[t] = coordinates;
        continue;
      }
      data_.triangles.push_back(part);
      parent.push_back(t);
      if (!data_.triangle_tags.empty()) data_.triangle_tags.push_back(number_of(t));
      if (textured) data_.texture.push_back(coordinates);
    }
  }

  void update_groups(const std::vector<Index>& parent) {
    for (mesh::Group& g : data_.groups) {
      std::set<Index> vertices(g.vertices.begin(), g.vertices.end());
      std::vector<Segment> segments;
      for (const Segment& e : g.segments) {
        const std::vector<Index> points = points_.chain(e[0], e[1]);
        for (std::size_t i = 0; i + 1 < points.size(); ++i) segments.push_back({points[i], points[i + 1]});
        vertices.insert(points.begin(), points.end());
      }
      const std::vector<Index> named = g.places();
      g.segments = std::move(segments);
      std::vector<char> in(parent.size(), 0);
      for (const Index t : g.triangles) in[t] = 1;
      g.triangles.clear();
      for (std::size_t t = 0; t < parent.size(); ++t)
        if (in[parent[t]]) {
          g.triangles.push_back(static_cast<Index>(t));
          vertices.insert(data_.triangles[t].begin(), data_.triangles[t].end());
        }
      g.vertices.assign(vertices.begin(), vertices.end());
      g.added.clear();
      std::set_difference(g.vertices.begin(), g.vertices.end(), named.begin(), named.end(),
                          std::back_inserter(g.added));
    }
    std::size_t next =
        data_.vertex_tags.empty() ? 0 : *std::max_element(data_.vertex_tags.begin(), data_.vertex_tags.end());
    while (!data_.vertex_tags.empty() && data_.vertex_tags.size() < data_.positions.size())
      data_.vertex_tags.push_back(++next);
  }

  mesh::MeshData& data_;
  double tolerance_;
  TiePoints points_;
  std::vector<Segment> rim_;
  std::vector<TrianglePair> crossing_;
  Tied tied_;
};

}  // namespace

Tied tie_parts(mesh::MeshData& data, double tolerance, std::vector<mesh::Segment> rims, Crossing crossing) {
  Index moved = move_to_rims(data, tolerance, rims);
  const bool joins = crossing == Crossing::joined;
  if (joins) moved += move_to_crossings(data, tolerance, rims);
  Tied tied = Tying(data, tolerance, rims).run(joins);
  tied.moved = moved;
  return tied;
}

}  // namespace voile::geometry

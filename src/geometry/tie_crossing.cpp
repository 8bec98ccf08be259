#include "tie_crossing.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>
#include <optional>
#include <tuple>

#include "mesh/coincident.hpp"

namespace voile::geometry {

namespace {

constexpr double flat = 0.05;  ///< sine between planes below which triangles lie on each other

struct Plane {
  Vec3 normal, at;
  [[nodiscard]] double height(const Vec3& x) const { return normal.dot(x - at); }
};

Plane plane_of(const std::array<Vec3, 3>& c) {
  return {(c[1] - c[0]).cross(c[2] - c[0]).normalized(), c[0]};
}

/// Where a segment with ends on both sides of a triangle passes through it.
std::optional<Vec3> piercing(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& c, double tolerance) {
  const Plane plane = plane_of(c);
  const double from = plane.height(a), to = plane.height(b);
  if (std::min(std::abs(from), std::abs(to)) <= tolerance || (from > 0.0) == (to > 0.0)) return std::nullopt;
  const Vec3 place = a + from / (from - to) * (b - a);
  if (distance_to_triangle(place, c) > tolerance) return std::nullopt;
  return place;
}

/// Vertices of triangles around each vertex are on both sides of planes, or not.
class Stars {
 public:
  explicit Stars(const mesh::MeshData& data) : data_(&data), star_(data.positions.size()) {
    for (const mesh::Triangle& t : data.triangles)
      for (const Index v : t) star_[v].insert(star_[v].end(), t.begin(), t.end());
  }
  [[nodiscard]] bool straddles(Index v, const Plane& plane, double tolerance) const {
    bool above = false, below = false;
    for (const Index w : star_[v]) {
      const double height = plane.height(data_->positions[w]);
      above = above || height > tolerance;
      below = below || height < -tolerance;
    }
    return above && below;
  }

 private:
  const mesh::MeshData* data_;
  std::vector<std::vector<Index>> star_;
};

bool is_corner(Index v, const mesh::Triangle& t) {
  return v == t[0] || v == t[1] || v == t[2];
}

/// Calls f(corner of the one, other triangle) for both triangles of a pair.
template <class Visit>
void each_corner(const mesh::MeshData& data, const TrianglePair& pair, const Visit& f) {
  for (const auto& [one, other] : {pair, TrianglePair(pair.second, pair.first)})
    for (const Index v : data.triangles[one])
      if (!is_corner(v, data.triangles[other])) f(v, other);
}

/// Calls f(side of the one, other triangle, place) for both triangles of a pair.
template <class Visit>
void each_piercing(const mesh::MeshData& data, const TrianglePair& pair, double tolerance, const Visit& f) {
  for (const auto& [one, other] : {pair, TrianglePair(pair.second, pair.first)}) {
    const std::array<Vec3, 3> corners = corners_of(data, other);
    const mesh::Triangle& t = data.triangles[one];
    for (std::size_t s = 0; s < 3; ++s) {
      const mesh::Segment side = mesh::ascending(t[s], t[(s + 1) % 3]);
      if (const auto place = piercing(data.positions[side[0]], data.positions[side[1]], corners, tolerance))
        f(side, other, *place);
    }
  }
}

}  // namespace

std::vector<TrianglePair> crossing_triangles(const mesh::MeshData& data, double tolerance,
                                             const std::vector<mesh::Segment>& rims) {
  const std::vector<TrianglePair> touching = intersecting_triangles(data.positions, data.triangles);
  if (touching.empty()) return {};
  const Stars stars(data);
  const std::vector<mesh::Segment> all = all_rims(data, rims);
  const auto at_rim = [&](Index triangle, const Vec3& place) {
    const mesh::Triangle& t = data.triangles[triangle];
    for (std::size_t s = 0; s < 3; ++s) {
      const mesh::Segment side = mesh::ascending(t[s], t[(s + 1) % 3]);
      if (distance_to_segment(place, data.positions[side[0]], data.positions[side[1]]) <= tolerance &&
          std::binary_search(all.begin(), all.end(), side))
        return true;
    }
    return false;
  };
  std::vector<TrianglePair> crossing;
  for (const TrianglePair& pair : touching) {
    const Plane one = plane_of(corners_of(data, pair.first)), other = plane_of(corners_of(data, pair.second));
    if (!(one.normal.cross(other.normal).norm() > flat)) continue;
    bool pierced = false;
    each_piercing(data, pair, tolerance, [&](const mesh::Segment&, Index triangle, const Vec3& place) {
      pierced = pierced || !at_rim(triangle, place);
    });
    each_corner(data, pair, [&](Index v, Index triangle) {
      const std::array<Vec3, 3> corners = corners_of(data, triangle);
      pierced = pierced || (distance_to_triangle(data.positions[v], corners) <= tolerance &&
                            stars.straddles(v, plane_of(corners), tolerance) && !at_rim(triangle, data.positions[v]));
    });
    if (pierced) crossing.push_back(pair);
  }
  return crossing;
}

Index move_to_crossings(mesh::MeshData& data, double tolerance, std::vector<mesh::Segment>& rims) {
  const TieSurface s = surface_of(data, rims);
  std::vector<std::tuple<double, Index, Vec3>> moves;
  const std::vector<TrianglePair> crossing = data.texture.empty()
                                                 ? crossing_triangles(data, tolerance)
                                                 : std::vector<TrianglePair>{};  // coordinates would stay
  for (const TrianglePair& pair : crossing)
    for (const auto& [one, other] : {pair, TrianglePair(pair.second, pair.first)}) {
      const std::array<Vec3, 3> corners = corners_of(data, other);
      const Plane own = plane_of(corners_of(data, one)), plane = plane_of(corners);
      const Vec3 slope = plane.normal - plane.normal.dot(own.normal) * own.normal;
      for (const Index v : data.triangles[one]) {
        const Vec3& x = data.positions[v];
        const Vec3 y = x - plane.height(x) / slope.squaredNorm() * slope;
        const double way = (y - x).norm();
        if (way > tolerance && way < tie_near * s.size[v] && distance_to_triangle(y, corners) <= tolerance)
          moves.emplace_back(way, v, y);
      }
    }
  std::sort(moves.begin(), moves.end(), [](const auto& a, const auto& b) {
    return std::tie(std::get<0>(a), std::get<1>(a)) < std::tie(std::get<0>(b), std::get<1>(b));
  });
  std::vector<char> taken(data.positions.size(), 0);
  Index moved = 0;
  for (const auto& [way, v, y] : moves) {
    if (taken[v] || !may_move(data, s, v, y, tolerance)) continue;
    taken[v] = 1;
    data.positions[v] = y;
    ++moved;
  }
  std::vector<Index> target(data.positions.size());
  std::iota(target.begin(), target.end(), Index{0});
  bool any = false;
  for (const TrianglePair& pair : crossing_triangles(data, tolerance, rims))
    each_corner(data, pair, [&](Index v, Index triangle) {
      for (const Index w : data.triangles[triangle])
        if ((data.positions[v] - data.positions[w]).norm() <= tolerance && target[v] == v && target[w] == w) {
          target[std::max(v, w)] = std::min(v, w);
          any = true;
        }
    });
  if (any) mesh::join_vertices(data, target, &rims);
  return moved;
}

Index pierce(const mesh::MeshData& data, const std::vector<TrianglePair>& pairs, TiePoints& points) {
  const double tolerance = points.tolerance();
  const auto before = points.all().size();
  const Stars stars(data);
  for (const TrianglePair& pair : pairs) {
    each_corner(data, pair, [&](Index v, Index triangle) {
      const std::array<Vec3, 3> corners = corners_of(data, triangle);
      if (distance_to_triangle(points.x(v), corners) <= tolerance && stars.straddles(v, plane_of(corners), tolerance))
        (void)points.put_in(v, triangle);
    });
  }
  for (const TrianglePair& pair : pairs)
    each_piercing(data, pair, tolerance, [&](const mesh::Segment& side, Index triangle, const Vec3& place) {
      for (const Index w : data.triangles[triangle])
        if ((points.x(w) - place).norm() <= tolerance) return points.put_on(w, side);
      for (const Index w : points.of_triangle(triangle))  // of another side that crosses one of this triangle there
        if ((points.x(w) - place).norm() <= tolerance) return points.put_on(w, side);
      const Index v = points.vertex_at(place, side, side);
      points.put_on(v, side);
      (void)points.put_in(v, triangle);
    });
  return static_cast<Index>(points.all().size() - before);
}

std::vector<mesh::Segment> lines_of(const mesh::MeshData& data, const std::vector<TrianglePair>& pairs,
                                    const TiePoints& points) {
  std::vector<mesh::Segment> lines;
  for (const auto& [one, other] : pairs) {
    std::vector<Index> a = points.of_triangle(one), b = points.of_triangle(other), both;
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    both.erase(std::unique(both.begin(), both.end()), both.end());
    const Vec3 along = plane_of(corners_of(data, one)).normal.cross(plane_of(corners_of(data, other)).normal);
    std::sort(both.begin(), both.end(),
              [&](Index v, Index w) { return points.x(v).dot(along) < points.x(w).dot(along); });
    for (std::size_t i = 0; i + 1 < both.size(); ++i) lines.push_back({both[i], both[i + 1]});
  }
  return lines;
}

}  // namespace voile::geometry

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mesh/coincident.hpp"
#include "tie_surface.hpp"

namespace voile::geometry {

namespace {

constexpr double sliver = 0.26;  ///< angle below which vertices are joined [rad]

double smallest_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto angle = [](const Vec3& u, const Vec3& w) { return std::atan2(u.cross(w).norm(), u.dot(w)); };
  return std::min({angle(b - a, c - a), angle(c - b, a - b), angle(a - c, b - c)});
}

bool is_touched(const mesh::Triangle& t, const std::vector<char>& touched) {
  return touched[t[0]] || touched[t[1]] || touched[t[2]];
}

/// Turns sides of pairs of triangles where that makes the smaller of their angles larger.
void turn_sides(mesh::MeshData& data, const std::vector<char>& touched, double tolerance) {
  TieSurface s = surface_of(data);
  const std::vector<Vec3>& x = data.positions;
  std::set<mesh::Segment> next;
  const auto add_sides = [&](Index t) {
    for (std::size_t i = 0; i < 3; ++i)
      next.insert(mesh::ascending(data.triangles[t][i], data.triangles[t][(i + 1) % 3]));
  };
  for (std::size_t t = 0; t < data.triangles.size(); ++t)
    if (is_touched(data.triangles[t], touched)) add_sides(static_cast<Index>(t));
  // Each turn makes the smaller of two angles larger, so this ends; round-off must not.
  for (std::size_t left = 100 * next.size(); !next.empty() && left > 0; --left) {
    const mesh::Segment edge = *next.begin();
    next.erase(next.begin());
    if (s.lines.count(edge) > 0) continue;
    const Index t = s.around[edge][0], u = s.around[edge][1];
    const mesh::Triangle& one = data.triangles[t];
    const std::size_t i = static_cast<std::size_t>(
        std::find_if(one.begin(), one.end(), [&](Index v) { return v != edge[0] && v != edge[1]; }) - one.begin());
    const Index c = one[i], a = one[(i + 1) % 3], b = one[(i + 2) % 3];
    const mesh::Triangle& two = data.triangles[u];
    const std::size_t j = static_cast<std::size_t>(std::find(two.begin(), two.end(), b) - two.begin());
    if (two[(j + 1) % 3] != a) continue;  // oriented otherwise
    const Index d = two[(j + 2) % 3];
    if (s.around.count(mesh::ascending(c, d)) > 0) continue;
    const Vec3 normal = (x[b] - x[a]).cross(x[c] - x[a]) + (x[a] - x[b]).cross(x[d] - x[b]);
    const Vec3 first = (x[d] - x[a]).cross(x[c] - x[a]), second = (x[b] - x[d]).cross(x[c] - x[d]);
    if (first.dot(normal) < 0.9 * first.norm() * normal.norm() ||
        second.dot(normal) < 0.9 * second.norm() * normal.norm())
      continue;
    const Vec3 across = (x[b] - x[a]).cross(x[d] - x[c]);
    const double shift = std::abs(across.dot(x[c] - x[a])) / across.norm();
    if (shift > std::max(tolerance, tie_same_shape * std::min((x[b] - x[a]).norm(), (x[d] - x[c]).norm()))) continue;
    const double before = std::min(smallest_angle(x[a], x[b], x[c]), smallest_angle(x[b], x[a], x[d]));
    const double after = std::min(smallest_angle(x[a], x[d], x[c]), smallest_angle(x[d], x[b], x[c]));
    if (after < before + 1e-6) continue;
    data.triangles[t] = {a, d, c};
    data.triangles[u] = {d, b, c};
    s.around.erase(edge);
    s.around[mesh::ascending(c, d)] = {t, u};
    std::replace(s.around[mesh::ascending(a, d)].begin(), s.around[mesh::ascending(a, d)].end(), u, t);
    std::replace(s.around[mesh::ascending(b, c)].begin(), s.around[mesh::ascending(b, c)].end(), t, u);
    add_sides(t);
    add_sides(u);
  }
}

/// Smallest angle of the triangles around two vertices; if `joined`, of those that are left when the first is the second.
double smallest_angle_around(const mesh::MeshData& data, const TieSurface& s, Index p, Index onto, bool joined) {
  double least = 4.0;
  for (const Index v : {p, onto})
    for (const Index t : s.star[v]) {
      const mesh::Triangle& corners = data.triangles[t];
      std::array<Vec3, 3> c = corners_of(data, t);
      if (joined) {
        const bool both = std::find(corners.begin(), corners.end(), p) != corners.end() &&
                          std::find(corners.begin(), corners.end(), onto) != corners.end();
        if (both) continue;
        for (std::size_t i = 0; i < 3; ++i)
          if (corners[i] == p) c[i] = data.positions[onto];
      }
      least = std::min(least, smallest_angle(c[0], c[1], c[2]));
    }
  return least;
}

std::set<Index> neighbours(const mesh::MeshData& data, const TieSurface& s, Index v) {
  std::set<Index> found;
  for (const Index t : s.star[v]) found.insert(data.triangles[t].begin(), data.triangles[t].end());
  found.erase(v);
  return found;
}

/// Whether the surface stays one when p becomes a neighbour: what is next to both is in a triangle with both.
bool keeps_topology(const mesh::MeshData& data, const TieSurface& s, Index p, Index onto) {
  const std::set<Index> one = neighbours(data, s, p), other = neighbours(data, s, onto);
  std::size_t common = 0;
  for (const Index v : one) common += other.count(v);
  return common == s.around.at(mesh::ascending(p, onto)).size();
}

/// Points and curves of the file that name each vertex: what acts on each of their vertices must not lose one.
std::vector<std::vector<std::size_t>> names_of(const mesh::MeshData& data) {
  std::vector<std::vector<std::size_t>> names(data.positions.size());
  for (std::size_t g = 0; g < data.groups.size(); ++g)
    if (data.groups[g].dimension < 2 && !(data.finds_boundary && data.groups[g].name.starts_with("boundary")))
      for (const Index v : data.groups[g].places()) names[v].push_back(g);
  return names;
}

bool share_name(const std::vector<std::size_t>& one, const std::vector<std::size_t>& other) {
  return std::any_of(one.begin(), one.end(),
                     [&](std::size_t g) { return std::find(other.begin(), other.end(), g) != other.end(); });
}

/// Joins vertices at the shortest sides of slivers. Returns whether there were any.
bool join_short_sides(mesh::MeshData& data, std::vector<char>& touched, double tolerance) {
  const TieSurface s = surface_of(data);
  const std::vector<Vec3>& x = data.positions;
  std::vector<std::tuple<double, Index, Index>> sides;
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    const mesh::Triangle& c = data.triangles[t];
    if (!is_touched(c, touched) || smallest_angle(x[c[0]], x[c[1]], x[c[2]]) > sliver) continue;
    std::array<std::tuple<double, Index, Index>, 3> three;
    for (std::size_t i = 0; i < 3; ++i) three[i] = {(x[c[i]] - x[c[(i + 1) % 3]]).norm(), c[i], c[(i + 1) % 3]};
    sides.push_back(*std::min_element(three.begin(), three.end()));
  }
  std::sort(sides.begin(), sides.end());
  std::vector<char> busy(x.size(), 0);
  std::vector<Index> target(x.size());
  std::iota(target.begin(), target.end(), Index{0});
  bool any = false;
  const std::vector<std::vector<std::size_t>> names = names_of(data);
  for (const auto& [length, a, b] : sides)
    for (const auto& [p, onto] : {std::pair(a, b), std::pair(b, a)}) {
      std::set<Index> around = neighbours(data, s, p);
      around.insert(p);
      if (std::any_of(around.begin(), around.end(), [&](Index v) { return busy[v]; })) continue;
      if (share_name(names[p], names[onto]) || !keeps_topology(data, s, p, onto) ||
          !may_move(data, s, p, x[onto], tolerance, onto))
        continue;
      if (smallest_angle_around(data, s, p, onto, true) <= smallest_angle_around(data, s, p, onto, false)) continue;
      target[p] = onto;
      for (const Index v : around) busy[v] = touched[v] = 1;
      any = true;
      break;
    }
  if (!any) return false;
  std::vector<char> left;
  for (std::size_t v = 0; v < target.size(); ++v)
    if (target[v] == static_cast<Index>(v)) left.push_back(touched[v]);
  touched = std::move(left);
  mesh::join_vertices(data, target);
  return true;
}

}  // namespace

void improve_angles(mesh::MeshData& data, const std::set<Index>& vertices, double tolerance) {
  if (!data.texture.empty()) return;
  std::vector<char> touched(data.positions.size(), 0);
  for (const Index v : vertices) touched[v] = 1;
  turn_sides(data, touched, tolerance);
  for (int round = 0; round < 10 && join_short_sides(data, touched, tolerance); ++round)
    turn_sides(data, touched, tolerance);
}

}  // namespace voile::geometry

#include "piercing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace voile::untangle {

namespace {

/// Most that a step along G moves, in lengths of the edge or of the triangle's sides, the smaller; 0.7 of it at this
/// |G|.
constexpr double contour_step = 0.2, contour_scale = 0.1;
/// An edge that grazes a triangle would go arbitrarily far along its normal.
constexpr double least_slope = 0.1;

std::optional<Piercing> pierce(const Tangle& tangle, const Segment& edge, Index face) {
  const std::vector<Vec3>& x = tangle.x;
  const auto& q = tangle.surface.faces[face].points;
  const Vec3 along = x[edge[1]] - x[edge[0]], u = x[q[1]] - x[q[0]], v = x[q[2]] - x[q[0]], n = u.cross(v);
  const double slope = along.dot(n), size = n.squaredNorm();
  if (std::abs(slope) <= tolerance * along.norm() * std::sqrt(size)) return std::nullopt;
  const double t = (x[q[0]] - x[edge[0]]).dot(n) / slope;
  if (t < -tolerance || t > 1.0 + tolerance) return std::nullopt;
  const Vec3 at = x[edge[0]] + t * along - x[q[0]];
  const double b = at.cross(v).dot(n) / size, c = u.cross(at).dot(n) / size;
  if (std::min({b, c, 1.0 - b - c}) < -tolerance) return std::nullopt;
  return Piercing{edge, face, t, Vec3(1.0 - b - c, b, c)};
}

/// R_k, zero if the face lies in the triangle's plane; `at`: where the edge, whose unit vector is e, meets the
/// triangle.
Vec3 line_into(const Tangle& tangle, const Segment& edge, Index face, const Vec3& e, const Vec3& n, const Vec3& at) {
  const auto& q = tangle.surface.faces[face].points;
  const Index apex = *std::find_if(q.begin(), q.end(), [&](Index v) { return v != edge[0] && v != edge[1]; });
  Vec3 r = n.cross(tangle.normal(face));
  if (r.norm() < tolerance) return Vec3::Zero();
  r.normalize();
  const Vec3 into = tangle.x[apex] - at;
  if ((into - into.dot(e) * e).dot(r) < 0.0) r = -r;
  return r;
}

/// [m]
double mean_side(const Tangle& tangle, Index face) {
  const auto& [a, b, c] = tangle.surface.faces[face].points;
  const std::vector<Vec3>& x = tangle.x;
  return ((x[a] - x[b]).norm() + (x[b] - x[c]).norm() + (x[c] - x[a]).norm()) / 3.0;
}

/// The edges of the triangles around one triangle; none if none of these is at a border.
std::set<Segment> patch_at_border(const Tangle& tangle, Index face) {
  std::set<Segment> patch;
  bool reaches_border = false;
  for (const Index v : tangle.surface.faces[face].points)
    for (const Index f : tangle.faces_of_point[v]) {
      const Face& near = tangle.surface.faces[f];
      for (const Segment& edge : edges_of(near)) patch.insert(edge);
      for (const Index q : near.points) reaches_border = reaches_border || tangle.on_border[q];
    }
  return reaches_border ? patch : std::set<Segment>();
}

}  // namespace

std::vector<Piercing> find_piercings(const Tangle& tangle, const FacePairs& pairs) {
  std::set<std::pair<Segment, Index>> tried;
  std::vector<Piercing> found;
  const auto try_edges = [&](Index from, Index to) {
    const auto& q = tangle.surface.faces[to].points;
    for (const Segment& edge : edges_of(tangle.surface.faces[from])) {
      const bool common = std::any_of(q.begin(), q.end(), [&](Index v) { return v == edge[0] || v == edge[1]; });
      if (common || !tried.insert({edge, to}).second) continue;
      if (const auto piercing = pierce(tangle, edge, to)) found.push_back(*piercing);
    }
  };
  for (const auto& [i, j] : pairs) {
    if (!tangle.is_face(i) || !tangle.is_face(j)) continue;
    try_edges(i, j);
    try_edges(j, i);
  }
  return found;
}

std::set<Segment> border_gaps(const Tangle& tangle, const std::vector<Piercing>& found) {
  std::set<Segment> cut;
  for (const Piercing& p : found)
    if (p.face < tangle.surface.sheet_faces && tangle.faces_of_edge.at(p.edge).size() == 1)
      cut.merge(patch_at_border(tangle, p.face));
  return cut;
}

Vec3 back_through(const Tangle& tangle, const Piercing& p, Index end) {
  const Surface& s = tangle.surface;
  const std::vector<Vec3>& x = tangle.x;
  const Index other = end == p.edge[0] ? p.edge[1] : p.edge[0];
  const Index corner = s.faces[p.face].points[0];
  Vec3 n = tangle.normal(p.face);
  if (n.dot(x[other] - x[end]) < 0.0) n = -n;
  const double gap =
      s.offset(s.body_of_point[end], s.body_of_point[corner]) + wanted_gap * tangle.options.activation_distance;
  return (n.dot(x[corner] - x[end]) + gap) * n;
}

Vec3 along_contour(const Tangle& tangle, const Piercing& p) {
  const std::vector<Vec3>& x = tangle.x;
  const Vec3 along = x[p.edge[1]] - x[p.edge[0]], e = along.normalized(), n = tangle.normal(p.face);
  const Vec3 at = x[p.edge[0]] + p.t * along;
  const double slope = std::copysign(std::max(std::abs(e.dot(n)), least_slope), e.dot(n));
  Vec3 g = Vec3::Zero();
  for (const Index f : tangle.faces_of_edge.at(p.edge)) {
    const Vec3 r = line_into(tangle, p.edge, f, e, n, at);
    g += r - e.dot(r) / slope * n;
  }
  const double most = contour_step * std::min(along.norm(), mean_side(tangle, p.face));
  return most / std::hypot(g.norm(), contour_scale) * g;
}

}  // namespace voile::untangle

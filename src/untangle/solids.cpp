#include "solids.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "geometry/winding.hpp"

namespace voile::untangle {

namespace {

using mesh::Triangle;

/// Triangles of the sheet that intersect those of a body.
std::set<Index> crossing_triangles(const Tangle& tangle, const FacePairs& pairs, int body) {
  const Surface& s = tangle.surface;
  std::set<Index> crossing;
  for (const auto& [i, j] : pairs)
    if (tangle.is_face(j) && s.faces[j].body == body && i < s.sheet_faces) crossing.insert(i);
  return crossing;
}

/// Per sheet point. Only across triangles that cross the surface can inside change to outside: one point of each region
/// tells for all.
std::vector<char> inside(const Tangle& tangle, const Solid& solid, const std::set<Index>& crossing) {
  const Surface& s = tangle.surface;
  std::set<Segment> cut;
  std::set<Index> concerned;  // pieces
  for (const Index f : crossing) {
    for (const Segment& edge : edges_of(s.faces[f])) cut.insert(edge);
    concerned.insert(tangle.pieces[s.faces[f].points[0]]);
  }
  const std::vector<Index> region = regions_without(s, cut);
  std::vector<char> result(region.size(), 0);
  for (Index v = 0; v < s.sheet_points; ++v) {
    if (concerned.count(tangle.pieces[v]) == 0 || !s.rules[solid.body][s.body_of_point[v]].touch) continue;
    const Index first = region[v];
    result[v] =
        first == v ? std::abs(geometry::winding_number(tangle.x[v], tangle.x, solid.triangles)) > 0.5 : result[first];
  }
  return result;
}

/// The shortest way from a place to a wide enough gap outside. [m]
Vec3 way_out(const Tangle& tangle, const Solid& solid, const Vec3& p) {
  const std::vector<Vec3>& x = tangle.x;
  const double distance = tangle.options.activation_distance;
  double best = std::numeric_limits<double>::infinity();
  Vec3 way = Vec3::Zero(), out = Vec3::UnitZ();
  for (const auto& [a, b, c] : solid.triangles) {
    const Vec3 low = x[a].cwiseMin(x[b]).cwiseMin(x[c]), high = x[a].cwiseMax(x[b]).cwiseMax(x[c]);
    if ((p - p.cwiseMax(low).cwiseMin(high)).squaredNorm() >= best * best) continue;
    const Closest near = point_triangle({p, x[a], x[b], x[c]});
    if (near.distance >= best) continue;
    best = near.distance;
    way = -near.w;
    out = (x[b] - x[a]).cross(x[c] - x[a]).normalized();
  }
  if (best > tolerance * distance) out = way / best;
  return way + (solid.offset + wanted_gap * distance) * out;
}

}  // namespace

Solids::Solids(const Surface& surface) {
  std::vector<std::vector<Triangle>> of_body(surface.bodies.size());
  for (std::size_t f = surface.sheet_faces; f < surface.faces.size(); ++f)
    of_body[surface.faces[f].body].push_back(surface.faces[f].points);
  for (int b = 0; b < static_cast<int>(of_body.size()); ++b)
    if (!of_body[b].empty() && geometry::is_closed(of_body[b]))
      solids_.push_back({b, surface.offset(b, 0), std::move(of_body[b])});
}

const Solid* Solids::find(int body) const {
  const auto at = std::find_if(solids_.begin(), solids_.end(), [&](const Solid& s) { return s.body == body; });
  return at == solids_.end() ? nullptr : &*at;
}

void Solids::leave(Tangle& tangle, const FacePairs& pairs) {
  deep_.clear();
  for (const Solid& solid : solids_) {
    const std::set<Index> crossing = crossing_triangles(tangle, pairs, solid.body);
    if (!crossing.empty()) leave(tangle, solid, crossing);
  }
}

void Solids::leave(Tangle& tangle, const Solid& solid, const std::set<Index>& crossing) {
  const std::vector<char> is_inside = inside(tangle, solid, crossing);
  std::vector<std::pair<Index, Vec3>> ways;
  for (Index v = 0; v < tangle.surface.sheet_points; ++v) {
    if (!is_inside[v] || deep_.count({solid.body, tangle.pieces[v]}) > 0) continue;
    const Vec3 way = way_out(tangle, solid, tangle.x[v]);
    if (way.norm() > tangle.options.limit) deep_.insert({solid.body, tangle.pieces[v]});
    ways.emplace_back(v, way);
  }
  for (const auto& [v, way] : ways)
    if (deep_.count({solid.body, tangle.pieces[v]}) == 0) tangle.x[v] += tangle.free[v] * way;
}

bool Solids::are_passed(const Tangle& tangle, const Piercing& p) const {
  const int body = tangle.surface.faces[p.face].body;
  return tangle.surface.is_sheet(p.edge[0]) && find(body) && deep_.count({body, tangle.pieces[p.edge[0]]}) == 0;
}

std::vector<Lift> Solids::lifts(const Tangle& tangle, const std::vector<Piercing>& found) const {
  std::map<std::pair<Segment, int>, Vec2> spans;  // first and last t
  for (const Piercing& p : found) {
    if (!are_passed(tangle, p)) continue;
    Vec2& span = spans.try_emplace({p.edge, tangle.surface.faces[p.face].body}, p.t, p.t).first->second;
    span = {std::min(span[0], p.t), std::max(span[1], p.t)};
  }
  std::vector<Lift> result;
  for (const auto& [key, span] : spans) {
    const auto& [edge, body] = key;
    const double t = span.mean();
    const Vec3 middle = (1.0 - t) * tangle.x[edge[0]] + t * tangle.x[edge[1]];
    result.push_back({edge, t, way_out(tangle, *find(body), middle)});
  }
  return result;
}

}  // namespace voile::untangle

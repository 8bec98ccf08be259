#include "voile/contact/untangle.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>

#include "voile/base/error.hpp"

namespace voile::contact {

namespace {

/// Shares of the contact distance: a gap below the first is widened to the second. From a smaller gap the barrier would
/// throw the sheet away: at half the distance with a hundred times the force.
constexpr double least_gap = 0.9, wanted_gap = 1.05;
/// Most that a step along G moves, in lengths of the edge or of the triangle's sides, the smaller; 0.7 of it at this
/// |G|.
constexpr double contour_step = 0.2, contour_scale = 0.1;
/// An edge that grazes a triangle would go arbitrarily far along its normal.
constexpr double least_slope = 0.1;
/// Passes over the pairs that are too near within a round.
constexpr int gap_passes = 3;
/// Piercing places count within so much of a triangle or edge beside it: the exact test has said that they meet.
constexpr double tolerance = 1e-9;

using Segment = mesh::Segment;
using Triangle = mesh::Triangle;

/// Edge a b meets triangle `face` at share t of the edge; `weights` of the triangle's corners there.
struct Piercing {
  Segment edge;
  Index face;
  double t;
  Vec3 weights;
};

/// Sets of numbers that grow together; the lowest member stands for its set.
class Sets {
 public:
  explicit Sets(Index count) : parent_(static_cast<std::size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  [[nodiscard]] Index of(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(Index i, Index j) {
    const auto [low, high] = std::minmax({of(i), of(j)});
    parent_[high] = low;
  }

 private:
  std::vector<Index> parent_;
};

Segment ascending(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Every directed edge has its reverse exactly once: closed, manifold and oriented, so that inside has a meaning.
bool is_closed(const std::vector<Triangle>& triangles) {
  std::set<std::pair<Index, Index>> edges;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k)
      if (!edges.emplace(t[k], t[(k + 1) % 3]).second) return false;
  return std::all_of(edges.begin(), edges.end(), [&](const auto& e) { return edges.count({e.second, e.first}) > 0; });
}

/// Regions of a sheet on the two sides of what pierces it.
struct Sides {
  Sets regions;
  std::map<Index, double> areas;     ///< of each region [m^2]
  std::map<Index, int> side;         ///< 0 or 1, of the regions at pierced edges
  std::array<double, 2> side_areas;  ///< [m^2]
};

/// A closed mesh among the obstacles.
struct Solid {
  int body;
  double offset;  ///< against the sheet [m]
  std::vector<Triangle> triangles;
};

class Untangler {
 public:
  Untangler(const Surface& surface, const std::vector<Plane>& planes, const std::vector<Mat3>& free,
            const UntangleOptions& options, std::vector<Vec3>& x)
      : s_(surface), planes_(planes), free_(free), options_(options), x_(x), pieces_(surface.sheet_points) {
    for (Index e = 0; e < s_.sheet_edges; ++e) pieces_.join(s_.edges[e].points[0], s_.edges[e].points[1]);
    has_faces_.assign(s_.bodies.size(), false);
    for (std::size_t f = 0; f < s_.faces.size(); ++f) {
      const Face& face = s_.faces[f];
      has_faces_[face.body] = true;
      for (int k = 0; k < 3; ++k)
        faces_of_edge_[ascending(face.points[k], face.points[(k + 1) % 3])].push_back(static_cast<Index>(f));
    }
    faces_of_point_.resize(static_cast<std::size_t>(s_.sheet_points));
    on_border_.assign(faces_of_point_.size(), false);
    for (Index f = 0; f < s_.sheet_faces; ++f)
      for (const Index v : s_.faces[f].points) faces_of_point_[v].push_back(f);
    for (const auto& [edge, faces] : faces_of_edge_)
      if (s_.is_sheet(edge[0]) && faces.size() == 1) on_border_[edge[0]] = on_border_[edge[1]] = true;
    find_solids();
  }

  using Pairs = std::vector<std::pair<Index, Index>>;

  void leave_solids(const Pairs& pairs);
  void uncross(const Pairs& pairs);
  /// Pairs with planes, balls and capsules, whose distance tells inside from outside, or all.
  void push_apart(bool all);
  [[nodiscard]] double smallest_gap() const;

 private:
  void find_solids();
  void leave_solid(const Solid& solid, const std::set<Index>& crossing);
  [[nodiscard]] std::vector<char> inside(const Solid& solid, const std::set<Index>& crossing) const;
  [[nodiscard]] Vec3 way_out(const Solid& solid, const Vec3& p) const;
  [[nodiscard]] std::vector<Piercing> piercings(const Pairs& pairs) const;
  [[nodiscard]] std::optional<Piercing> pierce(const Segment& edge, Index face) const;
  [[nodiscard]] bool passes_solid(const Piercing& p) const;
  [[nodiscard]] Sets sheet_without(const std::set<Segment>& cut) const;
  template <class Add>
  void lift_edges(const std::vector<Piercing>& found, Add&& add) const;
  [[nodiscard]] std::vector<Vec3> corrections(const std::vector<Piercing>& found) const;
  [[nodiscard]] Vec3 back_through(const Piercing& p, Index end) const;
  [[nodiscard]] Vec3 along_contour(const Piercing& p) const;
  [[nodiscard]] std::vector<Pair> near_pairs() const;
  [[nodiscard]] std::set<Segment> border_gaps(const std::vector<Piercing>& found) const;
  [[nodiscard]] Sides sides_of(const std::vector<Piercing>& group, std::set<Segment> cut) const;
  /// The end of a pierced edge that lies on the side of less area; no_index: both are in the same region.
  [[nodiscard]] static Index wrong_end(const Piercing& p, Sides& sides);
  /// What pierces: a piece of the sheet, or an obstacle.
  [[nodiscard]] Index origin(Index face) const {
    return face < s_.sheet_faces ? pieces_.of(s_.faces[face].points[0]) : s_.sheet_points + s_.faces[face].body;
  }

  [[nodiscard]] Vec3 normal(Index face) const {
    const auto& [a, b, c] = s_.faces[face].points;
    return (x_[b] - x_[a]).cross(x_[c] - x_[a]).normalized();
  }
  [[nodiscard]] double offset_of(Index a, Index b) const { return s_.offset(s_.body_of_point[a], s_.body_of_point[b]); }
  [[nodiscard]] double plane_gap(const Plane& p, Index i) const {
    return p.normal.dot(x_[i]) - p.level - s_.offset(p.body, s_.body_of_point[i]);
  }
  [[nodiscard]] bool is_solid_pair(const Pair& p) const { return !has_faces_[p.body_a] || !has_faces_[p.body_b]; }
  /// Calls add(point, movement) for the movements that change w by d.
  template <class Add>
  void share(const std::array<Index, 4>& points, const Vec4& c, const Vec3& d, Add&& add) const;

  const Surface& s_;
  const std::vector<Plane>& planes_;
  const std::vector<Mat3>& free_;
  const UntangleOptions& options_;
  std::vector<Vec3>& x_;
  mutable Sets pieces_;  ///< connected parts of the sheet
  std::vector<char> has_faces_;
  std::map<Segment, std::vector<Index>> faces_of_edge_;
  std::vector<std::vector<Index>> faces_of_point_;  ///< of the sheet
  std::vector<char> on_border_;                     ///< per sheet point
  std::vector<Solid> solids_;
  std::vector<char> is_solid_;            ///< by body
  std::set<std::pair<int, Index>> deep_;  ///< solids and pieces too deep in them to be moved out
};

void Untangler::find_solids() {
  std::vector<std::vector<Triangle>> of_body(s_.bodies.size());
  for (std::size_t f = s_.sheet_faces; f < s_.faces.size(); ++f)
    of_body[s_.faces[f].body].push_back(s_.faces[f].points);
  is_solid_.assign(of_body.size(), false);
  for (std::size_t b = 0; b < of_body.size(); ++b) {
    if (of_body[b].empty() || !is_closed(of_body[b])) continue;
    is_solid_[b] = true;
    solids_.push_back({static_cast<int>(b), s_.offset(static_cast<int>(b), 0), std::move(of_body[b])});
  }
}

template <class Add>
void Untangler::share(const std::array<Index, 4>& points, const Vec4& c, const Vec3& d, Add&& add) const {
  const double size = d.norm();
  if (!(size > 0.0)) return;
  const Vec3 n = d / size;
  double sum = 0.0;
  std::array<Vec3, 4> way;
  for (int i = 0; i < 4; ++i) {
    way[i].setZero();
    if (points[i] == no_index || !s_.is_sheet(points[i])) continue;
    way[i] = c[i] * (free_[points[i]] * n);
    sum += c[i] * n.dot(way[i]);
  }
  if (sum < tolerance) return;  // nothing that may move
  for (int i = 0; i < 4; ++i)
    if (!way[i].isZero(0.0)) add(points[i], Vec3(way[i] * (size / sum)));
}

// ---- closed meshes -------------------------------------------------------------------------------------------------

void Untangler::leave_solids(const Pairs& pairs) {
  deep_.clear();
  for (const Solid& solid : solids_) {
    std::set<Index> crossing;  // triangles of the sheet
    for (const auto& [i, j] : pairs) {
      if (j >= static_cast<Index>(s_.faces.size()) || s_.faces[j].body != solid.body) continue;
      if (i < s_.sheet_faces) crossing.insert(i);
    }
    if (!crossing.empty()) leave_solid(solid, crossing);
  }
}

void Untangler::leave_solid(const Solid& solid, const std::set<Index>& crossing) {
  const std::vector<char> is_inside = inside(solid, crossing);
  std::map<Index, std::vector<std::pair<Index, Vec3>>> ways;  // by piece
  std::set<Index> deep;
  for (Index v = 0; v < s_.sheet_points; ++v) {
    if (!is_inside[v]) continue;
    const Index piece = pieces_.of(v);
    if (deep.count(piece) > 0) continue;
    const Vec3 way = way_out(solid, x_[v]);
    if (way.norm() > options_.limit) {
      deep.insert(piece);
      deep_.insert({solid.body, piece});
    }
    ways[piece].emplace_back(v, way);
  }
  // A piece that lies deep inside may belong there, in a container: its line of intersection decides.
  for (const auto& [piece, list] : ways)
    if (deep.count(piece) == 0)
      for (const auto& [v, way] : list) x_[v] += free_[v] * way;
}

/// Only across triangles that cross the surface can inside change to outside: one point of each region tells for all.
std::vector<char> Untangler::inside(const Solid& solid, const std::set<Index>& crossing) const {
  std::set<Segment> cut;
  std::set<Index> concerned;
  for (const Index f : crossing) {
    const auto& p = s_.faces[f].points;
    for (int k = 0; k < 3; ++k) cut.insert(ascending(p[k], p[(k + 1) % 3]));
    concerned.insert(pieces_.of(p[0]));
  }
  Sets regions = sheet_without(cut);
  std::vector<char> result(static_cast<std::size_t>(s_.sheet_points), 0);
  for (Index v = 0; v < s_.sheet_points; ++v) {
    if (concerned.count(pieces_.of(v)) == 0 || !s_.rules[solid.body][s_.body_of_point[v]].touch) continue;
    const Index first = regions.of(v);
    result[v] = first == v ? std::abs(winding_number(x_[v], x_, solid.triangles)) > 0.5 : result[first];
  }
  return result;
}

Vec3 Untangler::way_out(const Solid& solid, const Vec3& p) const {
  double best = std::numeric_limits<double>::infinity();
  Vec3 way = Vec3::Zero(), out = Vec3::UnitZ();
  for (const auto& [a, b, c] : solid.triangles) {
    const Vec3 low = x_[a].cwiseMin(x_[b]).cwiseMin(x_[c]), high = x_[a].cwiseMax(x_[b]).cwiseMax(x_[c]);
    if ((p - p.cwiseMax(low).cwiseMin(high)).squaredNorm() >= best * best) continue;
    const Closest near = point_triangle({p, x_[a], x_[b], x_[c]});
    if (near.distance >= best) continue;
    best = near.distance;
    way = -near.w;
    out = (x_[b] - x_[a]).cross(x_[c] - x_[a]).normalized();
  }
  if (best > tolerance * options_.contact_distance) out = way / best;
  return way + (solid.offset + wanted_gap * options_.contact_distance) * out;
}

// ---- edges through triangles ---------------------------------------------------------------------------------------

std::optional<Piercing> Untangler::pierce(const Segment& edge, Index face) const {
  const auto& q = s_.faces[face].points;
  const Vec3 along = x_[edge[1]] - x_[edge[0]], u = x_[q[1]] - x_[q[0]], v = x_[q[2]] - x_[q[0]], n = u.cross(v);
  const double slope = along.dot(n), size = n.squaredNorm();
  if (std::abs(slope) <= tolerance * along.norm() * std::sqrt(size)) return std::nullopt;
  const double t = (x_[q[0]] - x_[edge[0]]).dot(n) / slope;
  if (t < -tolerance || t > 1.0 + tolerance) return std::nullopt;
  const Vec3 at = x_[edge[0]] + t * along - x_[q[0]];
  const double b = at.cross(v).dot(n) / size, c = u.cross(at).dot(n) / size;
  if (std::min({b, c, 1.0 - b - c}) < -tolerance) return std::nullopt;
  return Piercing{edge, face, t, Vec3(1.0 - b - c, b, c)};
}

std::vector<Piercing> Untangler::piercings(const Pairs& pairs) const {
  std::set<std::pair<Segment, Index>> tried;
  std::vector<Piercing> found;
  const auto try_edges = [&](Index from, Index to) {
    const auto &p = s_.faces[from].points, &q = s_.faces[to].points;
    for (int k = 0; k < 3; ++k) {
      const Segment edge = ascending(p[k], p[(k + 1) % 3]);
      const bool common = std::any_of(q.begin(), q.end(), [&](Index v) { return v == edge[0] || v == edge[1]; });
      if (common || !tried.insert({edge, to}).second) continue;
      if (const auto piercing = pierce(edge, to)) found.push_back(*piercing);
    }
  };
  for (const auto& [i, j] : pairs) {
    if (std::max(i, j) >= static_cast<Index>(s_.faces.size())) continue;
    try_edges(i, j);
    try_edges(j, i);
  }
  return found;
}

Index Untangler::wrong_end(const Piercing& p, Sides& sides) {
  const Index a = sides.regions.of(p.edge[0]), b = sides.regions.of(p.edge[1]);
  if (a == b) return no_index;
  const int side_a = sides.side.at(a), side_b = sides.side.at(b);
  const bool first =
      side_a == side_b ? sides.areas.at(a) < sides.areas.at(b) : sides.side_areas[side_a] < sides.side_areas[side_b];
  return first ? p.edge[0] : p.edge[1];
}

/// Where the border of one sheet ends a line of intersection on another close to the border of that: the two sides of
/// the line must not count as one region for the sake of the strip in between.
std::set<Segment> Untangler::border_gaps(const std::vector<Piercing>& found) const {
  std::set<Segment> cut;
  for (const Piercing& p : found) {
    if (p.face >= s_.sheet_faces || faces_of_edge_.at(p.edge).size() != 1) continue;
    std::set<Segment> patch;
    bool reaches_border = false;
    for (const Index v : s_.faces[p.face].points)
      for (const Index f : faces_of_point_[v])
        for (int k = 0; k < 3; ++k) {
          const auto& q = s_.faces[f].points;
          patch.insert(ascending(q[k], q[(k + 1) % 3]));
          reaches_border = reaches_border || on_border_[q[k]];
        }
    if (reaches_border) cut.merge(patch);
  }
  return cut;
}

/// Piercings of edges of one piece by one other thing: waves through a layer make many regions, which lie on two sides.
/// `cut`: further edges across which nothing belongs together.
Sides Untangler::sides_of(const std::vector<Piercing>& group, std::set<Segment> cut) const {
  std::set<Segment> pierced;
  for (const Piercing& p : group) pierced.insert(p.edge);
  cut.insert(pierced.begin(), pierced.end());
  Sides s{sheet_without(cut), {}, {}, {0.0, 0.0}};
  for (Index v = 0; v < s_.sheet_points; ++v) s.areas[s.regions.of(v)] += s_.area[v];
  std::map<Index, std::vector<Index>> beside;
  for (const Segment& e : pierced) {
    const Index a = s.regions.of(e[0]), b = s.regions.of(e[1]);
    beside[a].push_back(b);
    beside[b].push_back(a);
  }
  for (const auto& [first, ignored] : beside) {
    if (!s.side.try_emplace(first, 0).second) continue;
    for (std::vector<Index> next{first}; !next.empty();) {
      const Index at = next.back();
      next.pop_back();
      for (const Index other : beside[at])
        if (s.side.try_emplace(other, 1 - s.side[at]).second) next.push_back(other);
    }
  }
  for (const auto& [region, side] : s.side) s.side_areas[side] += s.areas[region];
  return s;
}

/// Whether an edge of the sheet passes through a solid that the sheet has left: both its ends are on the right side.
bool Untangler::passes_solid(const Piercing& p) const {
  const int body = s_.faces[p.face].body;
  return s_.is_sheet(p.edge[0]) && is_solid_[body] && deep_.count({body, pieces_.of(p.edge[0])}) == 0;
}

/// The parts into which cuts divide the sheet.
Sets Untangler::sheet_without(const std::set<Segment>& cut) const {
  Sets regions(s_.sheet_points);
  for (Index e = 0; e < s_.sheet_edges; ++e) {
    const auto& [a, b] = s_.edges[e].points;
    if (cut.count({a, b}) == 0) regions.join(a, b);
  }
  return regions;
}

/// What brings one end of an edge to the other side of the triangle.
Vec3 Untangler::back_through(const Piercing& p, Index end) const {
  const Index other = end == p.edge[0] ? p.edge[1] : p.edge[0];
  const Index corner = s_.faces[p.face].points[0];
  Vec3 n = normal(p.face);
  if (n.dot(x_[other] - x_[end]) < 0.0) n = -n;
  const double gap = offset_of(end, corner) + wanted_gap * options_.contact_distance;
  return (n.dot(x_[corner] - x_[end]) + gap) * n;
}

/// What shortens the line of intersection where it ends in, or passes, an edge.
Vec3 Untangler::along_contour(const Piercing& p) const {
  const Vec3 along = x_[p.edge[1]] - x_[p.edge[0]], e = along.normalized(), n = normal(p.face);
  const Vec3 at = x_[p.edge[0]] + p.t * along;
  const double slope = std::copysign(std::max(std::abs(e.dot(n)), least_slope), e.dot(n));
  Vec3 g = Vec3::Zero();
  for (const Index f : faces_of_edge_.at(p.edge)) {
    const auto& q = s_.faces[f].points;
    const Index apex = *std::find_if(q.begin(), q.end(), [&](Index v) { return v != p.edge[0] && v != p.edge[1]; });
    Vec3 r = n.cross(normal(f));
    if (r.norm() < tolerance) continue;
    r.normalize();
    const Vec3 into = x_[apex] - at;
    if ((into - into.dot(e) * e).dot(r) < 0.0) r = -r;
    g += r - e.dot(r) / slope * n;
  }
  const auto& c = s_.faces[p.face].points;
  const double side =
      ((x_[c[0]] - x_[c[1]]).norm() + (x_[c[1]] - x_[c[2]]).norm() + (x_[c[2]] - x_[c[0]]).norm()) / 3.0;
  return contour_step * std::min(along.norm(), side) / std::hypot(g.norm(), contour_scale) * g;
}

/// Edges of the sheet that pass through a solid with both ends outside: their middle inside goes the shortest way out.
template <class Add>
void Untangler::lift_edges(const std::vector<Piercing>& found, Add&& add) const {
  std::map<std::pair<Segment, int>, Vec2> spans;
  for (const Piercing& p : found) {
    const int body = s_.faces[p.face].body;
    if (!passes_solid(p)) continue;
    Vec2& span = spans.try_emplace({p.edge, body}, p.t, p.t).first->second;
    span = {std::min(span[0], p.t), std::max(span[1], p.t)};
  }
  for (const auto& [key, span] : spans) {
    const auto& [edge, body] = key;
    const Solid& solid =
        *std::find_if(solids_.begin(), solids_.end(), [b = body](const Solid& s) { return s.body == b; });
    const double t = span.mean();
    const Vec3 way = way_out(solid, (1.0 - t) * x_[edge[0]] + t * x_[edge[1]]);
    share({edge[0], edge[1], no_index, no_index}, Vec4(1.0 - t, t, 0.0, 0.0), way, add);
  }
}

std::vector<Vec3> Untangler::corrections(const std::vector<Piercing>& found) const {
  std::vector<Vec3> sum(static_cast<std::size_t>(s_.sheet_points), Vec3::Zero());
  std::vector<double> count(sum.size(), 0.0);
  const auto add = [&](Index v, const Vec3& d) {
    sum[v] += d;
    count[v] += 1.0;
  };
  const auto shorten = [&](const Piercing& p) {
    const auto& q = s_.faces[p.face].points;
    // The edge moves by half, the triangle by half the other way, or what alone may move by all.
    const Vec3 d = (s_.is_sheet(p.edge[0]) && s_.is_sheet(q[0]) ? 0.5 : 1.0) * along_contour(p);
    share({p.edge[0], p.edge[1], no_index, no_index}, Vec4(1.0 - p.t, p.t, 0.0, 0.0), d, add);
    share({q[0], q[1], q[2], no_index}, Vec4(p.weights[0], p.weights[1], p.weights[2], 0.0), -d, add);
  };
  lift_edges(found, add);
  std::map<std::pair<Index, Index>, std::vector<Piercing>> groups;
  for (const Piercing& p : found) {
    if (!s_.is_sheet(p.edge[0]))
      shorten(p);
    else if (!passes_solid(p))
      groups[{pieces_.of(p.edge[0]), origin(p.face)}].push_back(p);
  }
  const std::set<Segment> gaps = border_gaps(found);
  for (const auto& [parts, group] : groups) {
    Sides sides = sides_of(group, gaps);
    for (const Piercing& p : group) {
      const auto& q = s_.faces[p.face].points;
      const Vec3& b = p.weights;
      const Index end = wrong_end(p, sides);
      if (end == no_index)
        shorten(p);
      else
        share({end, q[0], q[1], q[2]}, Vec4(1.0, -b[0], -b[1], -b[2]), back_through(p, end), add);
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v)
    if (count[v] > 0.0) sum[v] /= count[v];
  return sum;
}

void Untangler::uncross(const Pairs& pairs) {
  const std::vector<Vec3> way = corrections(piercings(pairs));
  for (std::size_t v = 0; v < way.size(); ++v) x_[v] += way[v];
}

// ---- gaps ----------------------------------------------------------------------------------------------------------

std::vector<Pair> Untangler::near_pairs() const {
  std::vector<Box> boxes(x_.size());
  for (std::size_t i = 0; i < x_.size(); ++i) boxes[i].include(x_[i]);
  return find_pairs(s_, boxes, std::vector<char>(static_cast<std::size_t>(s_.sheet_points), 1),
                    options_.contact_distance);
}

namespace {

std::array<Vec3, 4> places(const Pair& pair, const std::vector<Vec3>& x) {
  std::array<Vec3, 4> p;
  for (int i = 0; i < 4; ++i) p[i] = pair.points[i] == no_index ? Vec3(Vec3::Zero()) : x[pair.points[i]];
  return p;
}

}  // namespace

void Untangler::push_apart(bool all) {
  const double least = least_gap * options_.contact_distance, wanted = wanted_gap * options_.contact_distance;
  const auto move = [&](Index v, const Vec3& d) { x_[v] += d; };
  const std::vector<Pair> pairs = near_pairs();
  for (int pass = 0; pass < gap_passes; ++pass) {
    for (const Plane& p : planes_)
      for (Index i = 0; i < s_.sheet_points; ++i) {
        const double gap = plane_gap(p, i);
        if (s_.rules[p.body][s_.body_of_point[i]].touch && gap < least)
          share({i, no_index, no_index, no_index}, Vec4::UnitX(), (wanted - gap) * p.normal, move);
      }
    for (const Pair& pair : pairs) {
      if (!all && !is_solid_pair(pair)) continue;
      const Closest near = closest(pair.kind, places(pair, x_));
      const double gap = near.distance - s_.offset(pair.body_a, pair.body_b);
      if (gap < least && near.distance > 0.0) share(pair.points, near.c, (wanted - gap) / near.distance * near.w, move);
    }
  }
}

double Untangler::smallest_gap() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Pair& pair : near_pairs())
    smallest = std::min(smallest, closest(pair.kind, places(pair, x_)).distance - s_.offset(pair.body_a, pair.body_b));
  for (const Plane& p : planes_)
    for (Index i = 0; i < s_.sheet_points; ++i)
      if (s_.rules[p.body][s_.body_of_point[i]].touch) smallest = std::min(smallest, plane_gap(p, i));
  return smallest;
}

void count_movement(const std::vector<Vec3>& from, const std::vector<Vec3>& to, UntangleResult& r) {
  r.moved = 0;
  r.farthest = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double way = (to[i] - from[i]).norm();
    if (way > 0.0) ++r.moved;
    r.farthest = std::max(r.farthest, way);
  }
}

}  // namespace

double winding_number(const Vec3& point, const std::vector<Vec3>& x, const std::vector<Triangle>& triangles) {
  double angle = 0.0;
  for (const auto& [i, j, k] : triangles) {
    const Vec3 a = x[i] - point, b = x[j] - point, c = x[k] - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4.0 * std::numbers::pi);
}

UntangleResult untangle(const Surface& surface, const std::vector<Plane>& planes, const std::vector<Mat3>& free,
                        const FindIntersections& find, const UntangleOptions& options, std::vector<Vec3>& x) {
  if (x.size() != surface.rest.size() || free.size() != static_cast<std::size_t>(surface.sheet_points))
    throw InternalError(fmt::format("untangle: {} positions and {} projectors for {} points, {} of the sheet", x.size(),
                                    free.size(), surface.points(), surface.sheet_points));
  const std::vector<Vec3> start = x;
  Untangler work(surface, planes, free, options, x);
  UntangleResult r, best;
  std::vector<Vec3> best_x;
  for (;; ++r.rounds) {
    const auto pairs = find(x);
    r.left = pairs.size();
    r.gap = work.smallest_gap();
    count_movement(start, x, r);
    r.done = pairs.empty() && r.gap > 0.0 && r.farthest <= options.limit;
    if (r.done && (!best.done || r.gap > best.gap)) {
      best = r;
      best_x = x;
    }
    const bool wide = r.gap >= least_gap * options.contact_distance;
    if ((r.done && wide) || r.rounds == options.rounds || r.farthest > options.limit) break;
    if (!pairs.empty()) {
      work.leave_solids(pairs);
      work.uncross(pairs);
    }
    work.push_apart(pairs.empty());
  }
  if (!best.done) return r;
  x = best_x;
  return best;
}

}  // namespace voile::contact

#include "surface_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/text.hpp"
#include "base/unions.hpp"
#include "continuations.hpp"
#include "voile/errors.hpp"

namespace voile::mesh {

namespace {

/// Rest corners closer than this, relative to their triangle, agree.
constexpr double agreement = 1e-9;
/// Largest ratio of the lengths of the two sides of a seam: gathers reach three.
constexpr double largest_stretch = 4.0;

Vec3 normal_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).cross(c - a).normalized();
}

/// Without area, or with a coordinate that is no number.
bool is_degenerate(const Vec3& x0, const Vec3& x1, const Vec3& x2) {
  const Vec3 a = x1 - x0, b = x2 - x0, c = b - a;
  const double longest = std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()});
  // Negated so that a NaN coordinate is caught too.
  return !(a.cross(b).norm() > 1e-10 * longest);
}

/// One side of one triangle, with its end points in ascending order so that equal edges sort together.
struct HalfEdge {
  Index low, high, triangle;
  int side;
};

std::vector<HalfEdge> sorted_half_edges(const std::vector<Triangle>& triangles) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * triangles.size());
  for (Index t = 0; t < static_cast<Index>(triangles.size()); ++t)
    for (int s = 0; s < 3; ++s) {
      const Index a = triangles[t][(s + 1) % 3], b = triangles[t][(s + 2) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t, s});
    }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& p, const HalfEdge& q) {
    return std::tie(p.low, p.high, p.triangle) < std::tie(q.low, q.high, q.triangle);
  });
  return edges;
}

/// "1, 2, 3 and 17 more": the first few names of a list that may be long.
std::string some_of(const std::vector<std::size_t>& names) {
  constexpr std::size_t shown = 8;
  const std::size_t n = std::min(shown, names.size());
  std::string text = join(std::vector(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(n)), ", ");
  if (names.size() > shown) text += fmt::format(" and {} more", names.size() - shown);
  return text;
}

}  // namespace

SurfaceMesh::SurfaceMesh(MeshData data) : data_(std::move(data)) {
  if (data_.triangles.empty())
    throw UserError(fmt::format("{}: the mesh has no triangles; mesh a surface (2-D) with 3-node triangles", source()));
  const auto nv = data_.positions.size(), nt = data_.triangles.size();
  while (data_.vertex_tags.size() < nv) data_.vertex_tags.push_back(data_.vertex_tags.size() + 1);
  while (data_.triangle_tags.size() < nt) data_.triangle_tags.push_back(data_.triangle_tags.size() + 1);
  check_geometry();
  build_adjacency();
  orient();
  count_components();
  build_vertex_triangles();
  check_groups();
  check_charts();
}

void SurfaceMesh::check_geometry() const {
  std::vector<std::size_t> flat;
  std::vector<char> used(data_.positions.size(), 0);
  for (Index t = 0; t < triangle_count(); ++t) {
    const Triangle& v = data_.triangles[t];
    for (Index i : v) {
      if (i < 0 || i >= vertex_count())
        throw UserError(
            fmt::format("{}: triangle {} names a vertex that does not exist", source(), data_.triangle_tags[t]));
      used[i] = 1;
    }
    const bool repeated = v[0] == v[1] || v[1] == v[2] || v[2] == v[0];
    if (repeated || is_degenerate(start_corner(t, 0), start_corner(t, 1), start_corner(t, 2)))
      flat.push_back(data_.triangle_tags[t]);
  }
  if (!flat.empty())
    throw UserError(fmt::format("{}: {} degenerate triangle(s) without area: {}; remove them or merge their vertices",
                                source(), flat.size(), some_of(flat)));
  std::vector<std::size_t> loose;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (!used[v]) loose.push_back(data_.vertex_tags[v]);
  if (!loose.empty())
    throw UserError(fmt::format("{}: {} vertex(es) belong to no triangle: {}", source(), loose.size(), some_of(loose)));
}

/// Where charts branch, seams must say on which side each lies.
void SurfaceMesh::check_joints_of_charts() const {
  for (const Joint& joint : joints_) {
    const auto folded =
        std::count_if(joint.sides.begin(), joint.sides.end(), [&](const TriangleSide& s) { return is_folded(s); });
    if (folded > 0 && folded < static_cast<std::ptrdiff_t>(joint.sides.size())) continue;
    throw UserError(fmt::format(
        "{}: {} edge(s) join three or more triangles, or two that cannot be oriented alike; one is {}. Sheets "
        "with a rest shape of their own (panels, mesh.rest = \"texture\") branch only along a seam: separate them, or "
        "remove the extra triangles",
        source(), joints_.size(), joint_text(joint)));
  }
}

void SurfaceMesh::check_charts() const {
  if (!has_charts()) return;
  check_joints_of_charts();
  if (data_.rest.size() != data_.triangles.size())
    throw UserError(fmt::format("{}: rest positions for {} triangles, but there are {}", source(), data_.rest.size(),
                                data_.triangles.size()));
  std::vector<std::size_t> flat;
  for (Index t = 0; t < triangle_count(); ++t)
    if (is_degenerate(rest_corner(t, 0), rest_corner(t, 1), rest_corner(t, 2))) flat.push_back(data_.triangle_tags[t]);
  if (!flat.empty())
    throw UserError(fmt::format(
        "{}: {} triangle(s) have no area in their rest shape: {}; correct the rest positions of their corners",
        source(), flat.size(), some_of(flat)));
  for (Index t = 0; t < triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      if (neighbours_[t][s] < t) continue;
      const double stretch = chart_join(t, s).stretch;
      if (std::max(stretch, 1.0 / stretch) <= largest_stretch) continue;
      throw UserError(
          fmt::format("{}: across the edge {}-{} the panels of triangles {} and {} differ in length by a factor of "
                      "{:.3g} at rest; a "
                      "seam can gather fabric up to {:g} times: check the scale of the two panels",
                      source(), data_.vertex_tags[data_.triangles[t][(s + 1) % 3]],
                      data_.vertex_tags[data_.triangles[t][(s + 2) % 3]], data_.triangle_tags[t],
                      data_.triangle_tags[neighbours_[t][s]], std::max(stretch, 1.0 / stretch), largest_stretch));
    }
}

void SurfaceMesh::build_adjacency() {
  const std::vector<HalfEdge> edges = sorted_half_edges(data_.triangles);
  neighbours_.assign(data_.triangles.size(), {no_index, no_index, no_index});
  shared_side_.assign(data_.triangles.size(), {-1, -1, -1});
  joints_.clear();
  std::vector<std::string> doubled;
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t last = first + 1;
    while (last < edges.size() && edges[last].low == edges[first].low && edges[last].high == edges[first].high) ++last;
    const auto tag = [&](std::size_t k) { return data_.triangle_tags[edges[k].triangle]; };
    const auto apex_of = [&](std::size_t k) { return data_.triangles[edges[k].triangle][edges[k].side]; };
    for (std::size_t k = first; k < last; ++k)
      for (std::size_t j = first; j < k; ++j)
        if (apex_of(k) == apex_of(j)) doubled.push_back(fmt::format("{} and {}", tag(j), tag(k)));
    const Segment edge{edges[first].low, edges[first].high};
    const auto parts = [&](const std::vector<Segment>& list) { return std::ranges::binary_search(list, edge); };
    const bool is_parted = parts(twisted_) || parts(data_.hinges) || parts(data_.borders);
    if (last - first > 2 || (last - first == 2 && is_parted)) {
      joints_.push_back({edge, {}});
      for (std::size_t k = first; k < last; ++k) joints_.back().sides.push_back({edges[k].triangle, edges[k].side});
    } else if (last - first == 2) {
      const HalfEdge &p = edges[first], &q = edges[first + 1];
      neighbours_[p.triangle][p.side] = q.triangle;
      neighbours_[q.triangle][q.side] = p.triangle;
      shared_side_[p.triangle][p.side] = q.side;
      shared_side_[q.triangle][q.side] = p.side;
    }
    first = last;
  }
  if (!doubled.empty())
    throw UserError(fmt::format("{}: duplicate triangles (the same three vertices): {}; delete one of each", source(),
                                doubled.front()));
}

bool SurfaceMesh::is_joint(Index t, int s) const {
  return std::any_of(joints_.begin(), joints_.end(), [&](const Joint& j) {
    return std::any_of(j.sides.begin(), j.sides.end(),
                       [&](const TriangleSide& side) { return side.triangle == t && side.side == s; });
  });
}

std::string SurfaceMesh::joint_text(const Joint& joint) const {
  std::vector<std::size_t> tags;
  for (const TriangleSide& s : joint.sides) tags.push_back(data_.triangle_tags[s.triangle]);
  return fmt::format("edge {}-{} (triangles {})", data_.vertex_tags[joint.edge[0]], data_.vertex_tags[joint.edge[1]],
                     some_of(tags));
}

void SurfaceMesh::orient() {
  std::vector<char> seen(data_.triangles.size(), 0), flip(data_.triangles.size(), 0);
  const std::map<Index, std::vector<Continuation>> across = continuations(data_, joints_);
  const auto spread_across = [&](Index t, std::vector<Index>& members) {
    const auto found = across.find(t);
    if (found == across.end()) return;
    for (const Continuation& c : found->second) {
      if (seen[c.next]) continue;
      seen[c.next] = 1;
      flip[c.next] = static_cast<char>(flip[t] ^ static_cast<char>(!c.opposite));
      members.push_back(c.next);
    }
  };
  for (Index seed = 0; seed < triangle_count(); ++seed) {
    if (seen[seed]) continue;
    std::vector<Index> members{seed};
    seen[seed] = 1;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const Index t = members[k];
      spread_orientation(t, members, seen, flip);
      spread_across(t, members);
    }
    const auto turned = std::count_if(members.begin(), members.end(), [&](Index t) { return flip[t]; });
    // Keep the orientation that most triangles already have.
    const char turn = 2 * static_cast<std::size_t>(turned) > members.size() ? 0 : 1;
    for (Index t : members)
      if (flip[t] == turn) {
        std::swap(data_.triangles[t][1], data_.triangles[t][2]);
        if (!data_.texture.empty()) std::swap(data_.texture[t][1], data_.texture[t][2]);
        if (!data_.rest.empty()) std::swap(data_.rest[t][1], data_.rest[t][2]);
        for (TriangleSide& s : data_.folded)
          if (s.triangle == t && s.side > 0) s.side = 3 - s.side;
        ++reoriented_;
      }
  }
  std::sort(data_.folded.begin(), data_.folded.end());
  std::sort(twisted_.begin(), twisted_.end());
  if (reoriented_ > 0 || !twisted_.empty()) build_adjacency();
}

void SurfaceMesh::count_components() {
  Unions connected(data_.triangles.size());
  components_ = triangle_count();
  const auto join = [&](Index a, Index b) { components_ -= connected.join(a, b) ? 1 : 0; };
  for (Index t = 0; t < triangle_count(); ++t)
    for (const Index n : neighbours_[t])
      if (n != no_index) join(t, n);
  for (const Joint& j : joints_)
    for (const TriangleSide& s : j.sides) join(j.sides.front().triangle, s.triangle);
}

/// Neighbours in the order of their numbers, so that which edges are found twisted does not depend on the orientation.
void SurfaceMesh::spread_orientation(Index t, std::vector<Index>& members, std::vector<char>& seen,
                                     std::vector<char>& flip) {
  std::array<int, 3> sides{0, 1, 2};
  std::sort(sides.begin(), sides.end(), [&](int a, int b) { return neighbours_[t][a] < neighbours_[t][b]; });
  for (const int s : sides) {
    const Index n = neighbours_[t][s];
    if (n == no_index) continue;
    const int sn = shared_side_[t][s];
    // Consistent neighbours run along the shared edge in opposite directions.
    const Index a = data_.triangles[t][(s + 1) % 3], b = data_.triangles[t][(s + 2) % 3];
    const char needs_flip = static_cast<char>(flip[t] ^ static_cast<char>(a == data_.triangles[n][(sn + 1) % 3]));
    if (!seen[n]) {
      seen[n] = 1;
      flip[n] = needs_flip;
      members.push_back(n);
    } else if (flip[n] != needs_flip && t < n) {
      twisted_.push_back({std::min(a, b), std::max(a, b)});
    }
  }
}

void SurfaceMesh::build_vertex_triangles() {
  vertex_triangle_start_.assign(data_.positions.size() + 1, 0);
  for (const Triangle& t : data_.triangles)
    for (Index v : t) ++vertex_triangle_start_[v + 1];
  for (std::size_t v = 0; v < data_.positions.size(); ++v) vertex_triangle_start_[v + 1] += vertex_triangle_start_[v];
  vertex_triangles_.resize(3 * data_.triangles.size());
  std::vector<Index> next(vertex_triangle_start_.begin(), vertex_triangle_start_.end() - 1);
  for (Index t = 0; t < triangle_count(); ++t)
    for (Index v : data_.triangles[t]) vertex_triangles_[next[v]++] = t;
}

void SurfaceMesh::check_groups() const {
  for (const Group& g : data_.groups)
    for (const Segment& segment : g.segments) {
      bool found = false;
      for (Index t : triangles_of_vertex(segment[0])) found = found || side_of(t, segment[0], segment[1]) >= 0;
      if (!found)
        throw UserError(fmt::format("{}: group '{}': the line element {}-{} is not an edge of any triangle", source(),
                                    g.name, data_.vertex_tags[segment[0]], data_.vertex_tags[segment[1]]));
    }
}

Index SurfaceMesh::apex(Index t, int s) const {
  const Index n = neighbours_[t][s];
  return n == no_index ? no_index : data_.triangles[n][shared_side_[t][s]];
}

bool SurfaceMesh::has_group(const std::string& name) const {
  return std::any_of(groups().begin(), groups().end(), [&](const Group& g) { return g.name == name; });
}

const Group& SurfaceMesh::group(const std::string& name, int dimension) const {
  std::vector<std::string> known;
  const Group* found = nullptr;
  for (const Group& g : groups())
    if (dimension < 0 || g.dimension == dimension) {
      known.push_back(g.name);
      if (g.name == name && (!found || g.dimension < found->dimension)) found = &g;
    }
  if (found) return *found;
  const std::string near = nearest(name, known);
  for (std::string& other : known) other = "'" + other + "'";
  throw UserError(fmt::format("{}: there is no {} group '{}'{}; the mesh has: {}", source(),
                              std::array{"physical", "point", "curve", "surface"}[dimension + 1], name,
                              near.empty() ? "" : fmt::format("; did you mean '{}'?", near),
                              known.empty() ? "none" : join(known, ", ")));
}

std::vector<Index> SurfaceMesh::triangles_of_vertex(Index v) const {
  return {vertex_triangles_.begin() + vertex_triangle_start_[v],
          vertex_triangles_.begin() + vertex_triangle_start_[v + 1]};
}

double SurfaceMesh::area(Index t) const {
  return triangle_area(rest_corner(t, 0), rest_corner(t, 1), rest_corner(t, 2));
}

Vec3 SurfaceMesh::rest_normal(Index t) const {
  return normal_of(rest_corner(t, 0), rest_corner(t, 1), rest_corner(t, 2));
}

Vec3 SurfaceMesh::start_normal(Index t) const {
  return normal_of(start_corner(t, 0), start_corner(t, 1), start_corner(t, 2));
}

double SurfaceMesh::rest_length(const Segment& edge) const {
  if (!has_charts()) return (data_.positions[edge[1]] - data_.positions[edge[0]]).norm();
  double sum = 0.0;
  int sides = 0;
  for (Index t : triangles_of_vertex(edge[0])) {
    const int s = side_of(t, edge[0], edge[1]);
    if (s < 0) continue;
    sum += (rest_corner(t, (s + 2) % 3) - rest_corner(t, (s + 1) % 3)).norm();
    ++sides;
  }
  return sum / sides;
}

Join SurfaceMesh::chart_join(Index t, int s) const {
  Join j;
  if (!has_charts()) return j;
  const Index n = neighbours_[t][s];
  const int sn = shared_side_[t][s];
  // The shared side runs the other way in the neighbour.
  const Vec3 a = rest_corner(t, (s + 1) % 3), b = rest_corner(t, (s + 2) % 3), an = rest_corner(n, (sn + 2) % 3),
             bn = rest_corner(n, (sn + 1) % 3);
  const double length = (b - a).norm();
  if (std::max((an - a).norm(), (bn - b).norm()) <= agreement * length) return j;
  j.same_chart = false;
  j.stretch = length / (bn - an).norm();
  const auto axes = [](const Vec3& along, const Vec3& normal) {
    Mat3 m;
    m << along, normal.cross(along), normal;
    return m;
  };
  j.turn = axes((b - a).normalized(), rest_normal(t)) * axes((bn - an).normalized(), rest_normal(n)).transpose();
  return j;
}

bool SurfaceMesh::starts_at_rest(Index t) const {
  if (!has_charts()) return true;
  const double tolerance = agreement * std::sqrt(area(t));
  for (int i = 0; i < 3; ++i)
    if ((rest_corner(t, i) - start_corner(t, i)).norm() > tolerance) return false;
  return true;
}

int SurfaceMesh::side_of(Index t, Index a, Index b) const {
  const Triangle& v = data_.triangles[t];
  for (int s = 0; s < 3; ++s) {
    const Index p = v[(s + 1) % 3], q = v[(s + 2) % 3];
    if ((p == a && q == b) || (p == b && q == a)) return s;
  }
  return -1;
}

double SurfaceMesh::extent() const {
  Vec3 low = data_.positions.front(), high = low;
  for (const Vec3& x : data_.positions) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 0.5 * (b - a).cross(c - a).norm();
}

}  // namespace voile::mesh

#include "surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace voile::adapt {

Surface::Surface(const mesh::SurfaceMesh& mesh, const RestSurface& rest_surface, const std::vector<Vec3>& places,
                 const std::vector<double>& sizes, const Limits& limits, const Options& options)
    : HalfEdges(half_edges(mesh)),
      place(places),
      size(sizes),
      first(&rest_surface),
      search(mesh),
      old_triangles(mesh.triangles()),
      old_size(&sizes),
      features(find_features(mesh, *this, limits, options.crease)),
      open_seams(mesh, *this),
      only_splits(options.only_splits) {
  const auto nt = static_cast<std::size_t>(mesh.triangle_count()), nv = static_cast<std::size_t>(mesh.vertex_count());
  side_class = features.side_class;
  triangle_class = features.triangle_class;
  dead.assign(nt, 0);
  touched.assign(nt, 0);
  frozen = limits.frozen.empty() ? std::vector<char>(nt, 0) : limits.frozen;
  rest_hint.assign(nt, no_index);
  gone.assign(nv, 0);
  dirty.assign(nv, 0);
  fixed = features.corner;
  on_feature = features.on_feature;
  leaving.assign(nv, no_index);
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    old_hint.push_back(t);
    for (int i = 0; i < 3; ++i) {
      rest.push_back(mesh.rest_corner(t, i));
      if (!mesh.data().texture.empty()) texture.push_back(mesh.data().texture[t][i]);
    }
  }
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    old.push_back(v);
    if (open_seams.holds(v)) fixed[v] = 1;
  }
  for (Index h = 0; h < side_count(); ++h)
    if (leaving[origin(h)] == no_index) leaving[origin(h)] = h;
  // Corners that agree within round-off must agree when their edges have become short, too.
  for (Index h = 0; h < side_count(); ++h) {
    const Index g = twin[h];
    if (g < h || frozen[g / 3] || !same_chart(mesh, h / 3, h % 3)) continue;
    rest[prev(g)] = rest[next(h)];
    rest[next(g)] = rest[prev(h)];
  }
  if (limits.clearance.empty()) return;
  moved.assign(nt, 0.0);
  for (const mesh::Triangle& t : mesh.triangles())
    allowed.push_back(std::min({limits.clearance[t[0]], limits.clearance[t[1]], limits.clearance[t[2]]}));
}

Index Surface::live_vertices() const {
  return static_cast<Index>(std::count(gone.begin(), gone.end(), 0));
}

/// The side on the boundary that joins two vertices, whichever way; no_index where two fans touch in one of them and
/// hide it.
Index Surface::boundary_side(Index a, Index b) const {
  for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, a}}) {
    const Index h = first_around(leaving[from]);
    if (twin[h] == no_index && dest(h) == to) return h;
  }
  return no_index;
}

Index Surface::across(Index h) const {
  if (twin[h] != no_index || open_seams.empty()) return twin[h];
  const OpenSeams::Edge* sewn = open_seams.find(origin(h), dest(h));
  return sewn == nullptr ? no_index : boundary_side(sewn->other[0], sewn->other[1]);
}

bool Surface::locked(Index h) const {
  const Index beyond = across(h);
  if (frozen[h / 3] || (beyond != no_index && frozen[beyond / 3])) return true;
  if (twin[h] != no_index || open_seams.empty()) return false;
  const OpenSeams::Edge* sewn = open_seams.find(origin(h), dest(h));
  // Halving one side of a triangle gives its others new numbers.
  return sewn != nullptr && (sewn->seam < 0 || beyond == no_index || beyond / 3 == h / 3);
}

double Surface::metric_length(Index h) const {
  double length = 2.0 * rest_length(h) / (size[origin(h)] + size[dest(h)]);
  const Index beyond = side_class[h] != 0 ? across(h) : no_index;
  if (beyond != no_index)
    length = std::max(length, 2.0 * rest_length(beyond) / (size[origin(beyond)] + size[dest(beyond)]));
  return length;
}

bool Surface::can_join(Index v, Index w) const {
  if (open_seams.empty()) return true;
  const std::vector<Index> at_w = open_seams.members(w);
  for (const Index a : open_seams.members(v))
    for (const Index b : at_w)
      if (a == b || joined(leaving[a], b)) return false;
  return true;
}

Vec3 Surface::rest_normal(Index t) const {
  return (rest[3 * t + 1] - rest[3 * t]).cross(rest[3 * t + 2] - rest[3 * t]).normalized();
}

Surface::Valence Surface::valence(Index e) const {
  const Index start = first_around(e);
  Valence v;
  v.inside = twin[start] != no_index;
  Index at = start;
  do {
    ++v.edges;
    at = left(at);
  } while (at != no_index && at != start);
  if (!v.inside) ++v.edges;
  return v;
}

bool Surface::joined(Index e, Index w) const {
  const Index start = first_around(e);
  Index at = start;
  do {
    if (dest(at) == w || apex(at) == w) return true;
    at = left(at);
  } while (at != no_index && at != start);
  return false;
}

double Surface::size_at(const Vec3& position, Index& hint) const {
  const ChartSearch::Hit hit = search.nearest(position, hint);
  hint = hit.triangle;
  double h = 0.0;
  for (std::size_t i = 0; i < 3; ++i) h += hit.weights[i] * (*old_size)[old_triangles[hit.triangle][i]];
  return h;
}

void Surface::link(Index a, Index b) {
  if (a != no_index) twin[a] = b;
  if (b != no_index) twin[b] = a;
}

Index Surface::add_triangle_like(Index t) {
  const Index n = triangle_slots();
  dead.push_back(0);
  frozen.push_back(0);
  touched.push_back(1);
  touched[t] = 1;
  triangle_class.push_back(triangle_class[t]);
  rest_hint.push_back(rest_hint[t]);
  old_hint.push_back(old_hint[t]);
  if (!allowed.empty()) {
    moved.push_back(moved[t]);
    allowed.push_back(allowed[t]);
  }
  for (int i = 0; i < 3; ++i) {
    vertex.push_back(vertex[3 * t + i]);
    twin.push_back(no_index);
    rest.push_back(rest[3 * t + i]);
    side_class.push_back(side_class[3 * t + i]);
    if (!texture.empty()) texture.push_back(texture[3 * t + i]);
  }
  return n;
}

/// Cuts the triangle of h from its apex to the new vertex m on h; the side from m to the old end of h.
Index Surface::half_split(Index h, Index m, const Vec3& at) {
  const Index other = 3 * add_triangle_like(h / 3) + h % 3;
  const Index beyond = twin[next(h)];
  vertex[prev(h)] = vertex[next(other)] = m;
  if (!texture.empty()) {
    const Vec2 middle = 0.5 * (texture[prev(h)] + texture[next(h)]);
    texture[prev(h)] = texture[next(other)] = middle;
  }
  rest[prev(h)] = rest[next(other)] = at;
  link(next(other), beyond);
  link(next(h), prev(other));
  side_class[next(h)] = side_class[prev(other)] = 0;
  leaving[dest(other)] = next(other);
  leaving[origin(h)] = h;
  return other;
}

std::array<Index, 2> Surface::split(Index h) {
  const Index o = origin(h), d = dest(h), other = twin[h] == no_index ? across(h) : no_index;
  const Index m = halve(h);
  if (other == no_index) return {m, no_index};
  const Index n = halve(other);
  open_seams.split(o, d, m, n);
  fixed[m] = fixed[n] = 1;
  return {m, n};
}

Vec3 Surface::carried(Index t, const Vec3& offset) const {
  Eigen::Matrix3d at_rest, now;
  for (Index i = 0; i < 2; ++i) {
    at_rest.col(i) = rest[3 * t + i + 1] - rest[3 * t];
    now.col(i) = place[vertex[3 * t + i + 1]] - place[vertex[3 * t]];
  }
  at_rest.col(2) = at_rest.col(0).cross(at_rest.col(1)).normalized();
  now.col(2) = now.col(0).cross(now.col(1)).normalized();
  return now * at_rest.inverse() * offset;
}

/// Where the rest shape is curved its middle lies beside the edge, and so it should now: what is not strained stays so. Zero
/// where contact leaves no room for that. Charged.
Vec3 Surface::room_off_edge(Index h, const Vec3& here, const Vec3& there) {
  if (allowed.empty() || only_splits || (twin[h] == no_index && across(h) != no_index)) return Vec3::Zero();
  const auto beside = [&](Index side, const Vec3& middle) -> Vec3 {
    const Vec3 offset = middle - 0.5 * (rest[next(side)] + rest[prev(side)]);
    return offset.isZero(0.0) ? Vec3::Zero() : carried(side / 3, offset);
  };
  const Index g = twin[h];
  std::vector<Index> triangles{h / 3};
  Vec3 off = beside(h, here);
  if (g != no_index) {
    off = 0.5 * (off + beside(g, there));
    triangles.push_back(g / 3);
  }
  const Budget b = budget(triangles);
  if (off.isZero(0.0) || !(b.moved + off.norm() <= b.allowed)) return Vec3::Zero();
  charge(triangles, b, off.norm());
  return off;
}

namespace {

/// Of the middle of an arc, per chord: that of a third of a circle.
constexpr double most_off_chord = 0.29;

}  // namespace

Index Surface::halve(Index h) {
  const Index g = twin[h], o = origin(h), d = dest(h);
  const bool line = side_class[h] != 0;
  const auto middle = [&](Index side) -> Vec3 {
    const Vec3 &a = rest[next(side)], &b = rest[prev(side)];
    Vec3 chord = 0.5 * (a + b);
    if (line) return first->curve_middle(a, b).value_or(chord);
    if (!first->curved()) return chord;
    Index& hint = rest_hint[side / 3];
    if (hint == no_index) hint = first->locate(chord, rest_normal(side / 3));
    // At a tip the surface through the first mesh leaps: a middle beyond the leap would leave a half as long as the edge.
    const Vec3 smooth = first->on_surface(chord, hint);
    return (smooth - chord).norm() <= most_off_chord * (b - a).norm() ? smooth : chord;
  };
  const Vec3 here = middle(h);
  Vec3 there = here;
  if (g != no_index && line && (rest[next(g)] != rest[prev(h)] || rest[prev(g)] != rest[next(h)])) there = middle(g);
  const Vec3 off = room_off_edge(h, here, there);
  const Index m = vertex_slots();
  gone.push_back(0);
  fixed.push_back(0);
  on_feature.push_back(line);
  dirty.push_back(1);
  dirty[o] = dirty[d] = dirty[apex(h)] = 1;
  place.push_back(0.5 * (place[o] + place[d]) + off);
  size.push_back(size_at(here, old_hint[h / 3]));
  old.push_back(no_index);
  leaving.push_back(no_index);
  const Index along = half_split(h, m, here);
  leaving[m] = along;
  if (g != no_index) {
    dirty[apex(g)] = 1;
    const Index back = half_split(g, m, there);
    link(h, back);
    link(along, g);
  }
  ++counts.splits;
  return m;
}

void Surface::flip(Index h) {
  const Index g = twin[h];
  const Index outer_h = next(g), outer_g = next(h);  // sides that become h and g
  const Index th = twin[outer_h], tg = twin[outer_g];
  const int ch = side_class[outer_h], cg = side_class[outer_g];
  vertex[prev(h)] = vertex[g];
  vertex[prev(g)] = vertex[h];
  rest[prev(h)] = rest[g];
  rest[prev(g)] = rest[h];
  if (!texture.empty()) {
    texture[prev(h)] = texture[g];
    texture[prev(g)] = texture[h];
  }
  twin[h] = twin[g] = no_index;
  link(h, th);
  link(g, tg);
  link(next(h), next(g));
  side_class[h] = ch;
  side_class[g] = cg;
  side_class[next(h)] = side_class[next(g)] = 0;
  for (const Index side : {h, g}) {
    leaving[origin(side)] = side;
    leaving[apex(side)] = prev(side);
    dirty[origin(side)] = dirty[apex(side)] = 1;
    touched[side / 3] = 1;
  }
  ++counts.flips;
}

Surface::Budget Surface::budget(const std::vector<Index>& triangles) const {
  Budget b{0.0, std::numeric_limits<double>::infinity()};
  if (allowed.empty()) return b;
  for (Index t : triangles) {
    b.moved = std::max(b.moved, moved[t]);
    b.allowed = std::min(b.allowed, allowed[t]);
  }
  return b;
}

void Surface::charge(const std::vector<Index>& triangles, const Budget& b, double displacement) {
  if (allowed.empty()) return;
  for (Index t : triangles) {
    moved[t] = b.moved + displacement;
    allowed[t] = b.allowed;
  }
}

}  // namespace voile::adapt

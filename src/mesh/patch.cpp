#include "patch.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "voile/errors.hpp"

namespace voile::mesh {

Vec2 unfold(const Vec3& a, const Vec3& b, const Vec2& pa, const Vec2& pb, const Vec3& x, double scale) {
  const Vec3 tangent = (b - a).normalized();
  const double along = (x - a).dot(tangent);
  const double away = (x - a - along * tangent).norm();
  const Vec2 t = (pb - pa).normalized();
  return pa + scale * along * t + scale * away * Vec2(t.y(), -t.x());
}

PatchMesh::PatchMesh(const SurfaceMesh& mesh, const std::vector<MirrorSide>& mirrors) : mesh_(&mesh) {
  slot_.assign(static_cast<std::size_t>(mesh.triangle_count()), no_index);
  for (const MirrorSide& m : mirrors) {
    if (mesh.neighbour(m.triangle, m.side) != no_index)
      throw UserError(fmt::format("{}: side {} of triangle {} is not on the boundary and cannot be mirrored",
                                  mesh.source(), m.side, mesh.data().triangle_tags[m.triangle]));
    if (slot_[m.triangle] == no_index) {
      slot_[m.triangle] = static_cast<Index>(mirror_of_side_.size());
      mirror_of_side_.push_back({no_index, no_index, no_index});
    }
    Index& here = mirror_of_side_[slot_[m.triangle]][m.side];
    if (here != no_index)
      throw UserError(fmt::format("{}: a boundary edge of triangle {} is clamped or mirrored twice", mesh.source(),
                                  mesh.data().triangle_tags[m.triangle]));
    here = mesh.vertex_count() + static_cast<Index>(mirrors_.size());
    mirrors_.push_back(make_mirror(m));
  }
}

MirrorPoint PatchMesh::make_mirror(const MirrorSide& side) const {
  const Triangle& t = mesh_->triangles()[side.triangle];
  const int a = (side.side + 1) % 3, b = (side.side + 2) % 3;
  MirrorPoint p;
  p.apex = t[side.side];
  p.a = t[a];
  p.b = t[b];
  p.reflection = side.reflection;
  const Vec3 rest_a = mesh_->rest_corner(side.triangle, a), edge = mesh_->rest_corner(side.triangle, b) - rest_a,
             apex = mesh_->rest_corner(side.triangle, side.side);
  p.foot = (apex - rest_a).dot(edge) / edge.squaredNorm();
  const Vec3 foot = rest_a + p.foot * edge;
  const bool in_space = mesh_->starts_at_rest(side.triangle);
  p.rest = in_space ? Vec3(foot + side.reflection * (apex - foot)) : Vec3(2.0 * foot - apex);
  p.start = p.rest;
  if (!mesh_->has_charts()) return p;
  const Vec3 start_a = mesh_->positions()[p.a];
  const Vec3 start_foot = start_a + p.foot * (mesh_->positions()[p.b] - start_a);
  p.start = start_foot + side.reflection * (mesh_->positions()[p.apex] - start_foot);
  return p;
}

Vec3 PatchMesh::rest_apex(Index t, int s) const {
  const Index n = mesh_->neighbour(t, s);
  if (n == no_index) return mirror(apex(t, s)).rest;
  const int sn = mesh_->side_in_neighbour(t, s);
  const Join join = mesh_->chart_join(t, s);
  Vec3 x = mesh_->rest_corner(n, sn);
  if (join.same_chart) return x;
  return mesh_->rest_corner(t, (s + 1) % 3) + join.stretch * join.turn * (x - mesh_->rest_corner(n, (sn + 2) % 3));
}

PatchMesh PatchMesh::cut_along(const std::vector<TriangleSide>& sides) const {
  PatchMesh cut = *this;
  cut.cut_.resize(static_cast<std::size_t>(mesh_->triangle_count()), {false, false, false});
  for (const TriangleSide& side : sides) cut.cut_[side.triangle][side.side] = true;
  return cut;
}

Index PatchMesh::apex(Index t, int s) const {
  if (!cut_.empty() && cut_[t][s]) return no_index;
  const Index vertex = mesh_->apex(t, s);
  if (vertex != no_index || slot_[t] == no_index) return vertex;
  return mirror_of_side_[slot_[t]][s];
}

Frame PatchMesh::frame(Index t, const std::optional<Vec3>& direction) const {
  Frame f;
  f.normal = mesh_->rest_normal(t);
  f.origin = (mesh_->rest_corner(t, 0) + mesh_->rest_corner(t, 1) + mesh_->rest_corner(t, 2)) / 3.0;
  // Without a direction: global x where it is usable, so that neighbouring frames agree.
  const Vec3 wanted = direction                      ? direction->normalized()
                      : std::abs(f.normal.x()) < 0.9 ? Vec3::UnitX()
                                                     : Vec3::UnitY();
  const Vec3 projected = wanted - wanted.dot(f.normal) * f.normal;
  if (projected.norm() < 1e-6)
    throw UserError(
        fmt::format("{}: the material direction [{}, {}, {}] is normal to triangle {}; choose a direction "
                    "that has a component in the surface",
                    mesh_->source(), wanted.x(), wanted.y(), wanted.z(), mesh_->data().triangle_tags[t]));
  f.e1 = projected.normalized();
  f.e2 = f.normal.cross(f.e1);
  return f;
}

Patch PatchMesh::patch(Index t, const Frame& frame) const {
  Patch p;
  p.area = mesh_->area(t);
  for (int i = 0; i < 3; ++i) {
    p.points[i] = mesh_->triangles()[t][i];
    p.rest[i] = mesh_->rest_corner(t, i);
    p.coordinates[i] = frame.to_plane(p.rest[i]);
  }
  for (int s = 0; s < 3; ++s) {
    p.points[3 + s] = apex(t, s);
    if (p.points[3 + s] == no_index) continue;
    const int a = (s + 1) % 3, b = (s + 2) % 3;
    p.rest[3 + s] = rest_apex(t, s);
    p.coordinates[3 + s] = unfold(p.rest[a], p.rest[b], p.coordinates[a], p.coordinates[b], p.rest[3 + s]);
    if (mesh_->neighbour(t, s) != no_index) p.stretch[s] = mesh_->chart_join(t, s).stretch;
  }
  return p;
}

namespace {

/// A triangle of a tree that is unfolded into the plane of its first one: a vertex can appear at two places of a cone.
struct Unfolded {
  std::array<Vec2, 3> corners{};
  double scale = 1.0;  ///< takes its chart to that of the first triangle: X -> shift + scale turn X
  Mat3 turn = Mat3::Identity();
  Vec3 shift = Vec3::Zero();

  [[nodiscard]] Vec3 to_chart(const Vec3& x) const { return shift + scale * (turn * x); }
  /// The map of a neighbour in whose chart a corner of the common side lies at `there`, in this one's at `here`.
  [[nodiscard]] Unfolded across(const Join& join, const Vec3& here, const Vec3& there) const {
    Unfolded n;
    n.scale = scale;
    n.turn = turn;
    n.shift = shift;
    if (join.same_chart) return n;
    n.scale *= join.stretch;
    n.turn = turn * join.turn;
    n.shift = to_chart(here) - n.scale * (n.turn * there);
    return n;
  }
};

}  // namespace

std::vector<PatchMesh::UnfoldedPoint> PatchMesh::unfolded_rings(Index t, int side, int rings,
                                                                const Frame& frame) const {
  // Ring by ring: the triangles that touch a vertex reached so far, then their unfolding outwards from t.
  std::set<Index> region{t}, reached;
  if (side >= 0 && mesh_->neighbour(t, side) != no_index) region.insert(mesh_->neighbour(t, side));
  std::set<Index> core;
  for (int i = 0; i < 3; ++i)
    if (side < 0 || i != side) core.insert(mesh_->triangles()[t][i]);
  for (int r = 0; r < rings; ++r) {
    if (r > 0)
      for (Index k : region) core.insert(mesh_->triangles()[k].begin(), mesh_->triangles()[k].end());
    for (Index v : core)
      for (Index k : mesh_->triangles_of_vertex(v)) region.insert(k);
  }
  std::map<Index, UnfoldedPoint> place;
  std::map<Index, Unfolded> unfolded;
  std::vector<Index> queue{t};
  for (int i = 0; i < 3; ++i) {
    const Vec3 rest = mesh_->rest_corner(t, i);
    unfolded[t].corners[i] = frame.to_plane(rest);
    const Index v = mesh_->triangles()[t][i];
    place.emplace(v, UnfoldedPoint{v, unfolded[t].corners[i], rest});
  }
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const Index from = queue[k];
    const Unfolded here = unfolded[from];
    for (int s = 0; s < 3; ++s) {
      const int a = (s + 1) % 3, b = (s + 2) % 3;
      const Index point = apex(from, s), next = mesh_->neighbour(from, s);
      if (point == no_index || (next != no_index && (!region.count(next) || unfolded.count(next)))) continue;
      const Vec3 rest = rest_apex(from, s);
      const Vec2 at = unfold(mesh_->rest_corner(from, a), mesh_->rest_corner(from, b), here.corners[a], here.corners[b],
                             rest, here.scale);
      place.emplace(point, UnfoldedPoint{point, at, here.to_chart(rest)});
      if (next == no_index) continue;  // mirror point
      const int sn = mesh_->side_in_neighbour(from, s);
      Unfolded& there = unfolded[next];
      there =
          here.across(mesh_->chart_join(from, s), mesh_->rest_corner(from, a), mesh_->rest_corner(next, (sn + 2) % 3));
      there.corners[sn] = at;
      // The shared side runs the other way in the neighbour.
      there.corners[(sn + 1) % 3] = here.corners[b];
      there.corners[(sn + 2) % 3] = here.corners[a];
      queue.push_back(next);
    }
  }
  std::vector<UnfoldedPoint> result;
  for (const auto& entry : place) result.push_back(entry.second);
  return result;
}

double PatchMesh::rest_dihedral(Index t, int s) const {
  const Index n = mesh_->neighbour(t, s);
  if (n == no_index || !mesh_->chart_join(t, s).same_chart) return 0.0;
  const Vec3 p = mesh_->rest_normal(t), q = mesh_->rest_normal(n);
  return std::atan2(p.cross(q).norm(), p.dot(q));
}

}  // namespace voile::mesh

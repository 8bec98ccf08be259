#include "voile/mesh/patch.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "voile/base/error.hpp"

namespace voile::mesh {

Vec2 unfold(const Vec3& a, const Vec3& b, const Vec2& pa, const Vec2& pb, const Vec3& x) {
  const Vec3 tangent = (b - a).normalized();
  const double along = (x - a).dot(tangent);
  const double away = (x - a - along * tangent).norm();
  const Vec2 t = (pb - pa).normalized();
  return pa + along * t + away * Vec2(t.y(), -t.x());
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
    const Triangle& t = mesh.triangles()[m.triangle];
    MirrorPoint p{t[m.side], t[(m.side + 1) % 3], t[(m.side + 2) % 3], 0.0, m.reflection, Vec3::Zero()};
    const Vec3 a = mesh.positions()[p.a], edge = mesh.positions()[p.b] - a, apex = mesh.positions()[p.apex];
    p.foot = (apex - a).dot(edge) / edge.squaredNorm();
    const Vec3 foot = a + p.foot * edge;
    p.rest = foot + m.reflection * (apex - foot);
    mirrors_.push_back(p);
  }
}

Index PatchMesh::apex(Index t, int s) const {
  const Index vertex = mesh_->apex(t, s);
  if (vertex != no_index || slot_[t] == no_index) return vertex;
  return mirror_of_side_[slot_[t]][s];
}

Frame PatchMesh::frame(Index t, const std::optional<Vec3>& direction) const {
  Frame f;
  f.normal = mesh_->unit_normal(t);
  f.origin = (mesh_->corner(t, 0) + mesh_->corner(t, 1) + mesh_->corner(t, 2)) / 3.0;
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
    p.coordinates[i] = frame.to_plane(mesh_->corner(t, i));
  }
  for (int s = 0; s < 3; ++s) {
    p.points[3 + s] = apex(t, s);
    if (p.points[3 + s] == no_index) continue;
    const int a = (s + 1) % 3, b = (s + 2) % 3;
    p.coordinates[3 + s] =
        unfold(mesh_->corner(t, a), mesh_->corner(t, b), p.coordinates[a], p.coordinates[b], rest(p.points[3 + s]));
  }
  return p;
}

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
  std::map<Index, Vec2> place;
  std::map<Index, std::array<Vec2, 3>> corners;  // of unfolded triangles: a vertex can appear at two places of a cone
  std::vector<Index> queue{t};
  for (int i = 0; i < 3; ++i) {
    corners[t][i] = frame.to_plane(mesh_->corner(t, i));
    place.emplace(mesh_->triangles()[t][i], corners[t][i]);
  }
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const Index from = queue[k];
    const std::array<Vec2, 3> p = corners[from];
    for (int s = 0; s < 3; ++s) {
      const int a = (s + 1) % 3, b = (s + 2) % 3;
      const Index point = apex(from, s);
      if (point == no_index) continue;
      const Vec2 at = unfold(mesh_->corner(from, a), mesh_->corner(from, b), p[a], p[b], rest(point));
      const Index next = mesh_->neighbour(from, s);
      if (next == no_index) {
        place.emplace(point, at);  // mirror point
      } else if (region.count(next) && !corners.count(next)) {
        const int sn = mesh_->side_in_neighbour(from, s);
        corners[next][sn] = at;
        // The shared side runs the other way in the neighbour.
        corners[next][(sn + 1) % 3] = p[b];
        corners[next][(sn + 2) % 3] = p[a];
        place.emplace(point, at);
        queue.push_back(next);
      }
    }
  }
  std::vector<UnfoldedPoint> result;
  for (const auto& [point, at] : place) result.push_back({point, at});
  return result;
}

double PatchMesh::rest_dihedral(Index t, int s) const {
  const Index n = mesh_->neighbour(t, s);
  if (n == no_index) return 0.0;
  const Vec3 p = mesh_->unit_normal(t), q = mesh_->unit_normal(n);
  return std::atan2(p.cross(q).norm(), p.dot(q));
}

}  // namespace voile::mesh

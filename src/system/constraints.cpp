#include "constraints.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "base/decompositions.hpp"
#include "mesh/border.hpp"
#include "mirror_plane.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

/// u.direction = value
struct Condition {
  Vec3 direction;
  double value;
};
using Conditions = std::map<Index, std::vector<Condition>>;

std::string name_of(const Support& s) {
  const auto kind = [&] {
    switch (s.kind) {
      case Support::Kind::displacement:
        return "displacement";
      case Support::Kind::hinged:
        return "hinged";
      case Support::Kind::clamped:
        return "clamped";
      case Support::Kind::sliding:
        return "sliding";
      case Support::Kind::symmetry:
        break;
    }
    return "symmetry";
  };
  return fmt::format("[[support]] group '{}' ({})", s.group, kind());
}

/// Boundary sides of a curve group, as (triangle, side).
std::vector<mesh::MirrorSide> boundary_sides(const mesh::SurfaceMesh& mesh, const mesh::Group& group,
                                             const Support& support) {
  std::vector<mesh::MirrorSide> sides;
  for (const mesh::Segment& segment : group.segments)
    for (Index t : mesh.triangles_of_vertex(segment[0])) {
      const int s = mesh.side_of(t, segment[0], segment[1]);
      if (s < 0) continue;
      if (mesh.neighbour(t, s) != no_index)
        throw UserError(
            fmt::format("{}: the edge {}-{} lies inside the surface; only boundary edges can be clamped or "
                        "mirrored: use `hinged`, or split the surface along the curve",
                        name_of(support), mesh.data().vertex_tags[segment[0]], mesh.data().vertex_tags[segment[1]]));
      sides.push_back({t, s, Mat3::Identity()});
    }
  return sides;
}

/// Normal of the plane of a curve that is all but straight, along the axis, as the edge of a plate with a small imperfection; nothing
/// where its vertices are off a line by no more than round-off, or to all sides.
std::optional<Vec3> plane_of_bow(const mesh::SurfaceMesh& mesh, const mesh::Group& group, const Vec3& centre,
                                 const Vec3& axis) {
  constexpr double round_off = 1e-9, plane = 1e-3;
  const auto off = [&](Index v) {
    const Vec3 d = mesh.positions()[v] - centre;
    return Vec3(d - axis.dot(d) * axis);
  };
  Vec3 most = Vec3::Zero();
  for (const Index v : group.vertices)
    if (off(v).squaredNorm() > most.squaredNorm()) most = off(v);
  if (most.norm() <= round_off * mesh.extent()) return std::nullopt;
  const Vec3 normal = axis.cross(most).normalized();
  const auto lies = [&](Index v) { return std::abs(normal.dot(off(v))) <= plane * most.norm(); };
  if (!std::all_of(group.vertices.begin(), group.vertices.end(), lies)) return std::nullopt;
  return normal;
}

/// Normal of the plane that holds the group; for a straight edge of a flat surface its in-plane normal.
Vec3 symmetry_normal(const mesh::SurfaceMesh& mesh, const mesh::Group& group,
                     const std::vector<mesh::MirrorSide>& sides, const Support& support) {
  if (support.normal) return support.normal->normalized();
  Vec3 centre = Vec3::Zero();
  for (Index v : group.vertices) centre += mesh.positions()[v];
  centre /= static_cast<double>(group.vertices.size());
  Mat3 moment = Mat3::Zero();
  for (Index v : group.vertices) {
    const Vec3 d = mesh.positions()[v] - centre;
    moment += d * d.transpose();
  }
  const Spectrum inertia = spectrum(moment);
  const double largest = inertia.values[2];
  Vec3 flattest = inertia.vectors.col(0);
  // A mirror plane crosses the sheet.
  constexpr double along_sheet = 0.7;
  const bool crosses = std::any_of(sides.begin(), sides.end(), [&](const mesh::MirrorSide& m) {
    return std::abs(flattest.dot(mesh.start_normal(m.triangle))) <= along_sheet;
  });
  if (inertia.values[1] > 1e-10 * largest) {
    if (inertia.values[0] > 1e-10 * largest)
      throw UserError(name_of(support) +
                      ": the group's vertices do not lie in a plane; write a [[support]] for each plane, or give "
                      "the `normal` of the one plane");
    if (!crosses)
      throw UserError(name_of(support) +
                      ": its edges lie on several lines of a flat sheet; write a [[support]] for each straight edge");
    return flattest;
  }
  if (const std::optional<Vec3> plane = plane_of_bow(mesh, group, centre, inertia.vectors.col(2)))
    if (std::abs(plane->dot(mesh.start_normal(sides.front().triangle))) <= along_sheet) return *plane;
  Vec3 normal = Vec3::Zero();
  for (const mesh::MirrorSide& m : sides) {
    // On a curved surface the facets along a straight edge only approximate the tangent plane.
    for (Index v : mesh.triangles()[m.triangle])
      for (Index t : mesh.triangles_of_vertex(v))
        if ((mesh.start_normal(t) - mesh.start_normal(m.triangle)).norm() > 1e-6)
          throw UserError(name_of(support) +
                          ": the plane of a straight edge on a curved surface cannot be found from "
                          "the mesh; give its `normal`, for example normal = [1, 0, 0]");
    const Vec3 along =
        mesh.start_corner(m.triangle, (m.side + 2) % 3) - mesh.start_corner(m.triangle, (m.side + 1) % 3);
    normal += along.cross(mesh.start_normal(m.triangle));
  }
  if (normal.norm() < 1e-12) throw UserError(name_of(support) + ": cannot find the plane; give its `normal`");
  return normal.normalized();
}

void add_symmetry(const mesh::SurfaceMesh& mesh, const Support& support, Constraints& result, Conditions& conditions) {
  const mesh::Group& group = mesh.group(support.group, 1);
  std::vector<mesh::MirrorSide> sides = boundary_sides(mesh, group, support);
  for (const mesh::MirrorSide& m : sides)
    if (mesh.is_joint(m.triangle, m.side))
      throw UserError(
          fmt::format("{}: its edge {}-{} joins sheets, one of which may lie in the plane; model the whole, or cut it "
                      "where no sheets are joined",
                      name_of(support), mesh.data().vertex_tags[mesh.triangles()[m.triangle][(m.side + 1) % 3]],
                      mesh.data().vertex_tags[mesh.triangles()[m.triangle][(m.side + 2) % 3]]));
  const Vec3 normal = symmetry_normal(mesh, group, sides, support);
  const Vec3 origin = mesh.positions()[group.vertices.front()];
  const double tolerance = 1e-6 * mesh.extent();
  for (Index v : group.vertices)
    if (std::abs(normal.dot(mesh.positions()[v] - origin)) > tolerance)
      throw UserError(
          fmt::format("{}: vertex {} does not lie in the plane with normal [{:.6g}, {:.6g}, {:.6g}] through "
                      "the group's first vertex; correct `normal` or the group",
                      name_of(support), mesh.data().vertex_tags[v], normal.x(), normal.y(), normal.z()));
  for (mesh::MirrorSide& m : sides) {
    m.reflection = Mat3::Identity() - 2.0 * normal * normal.transpose();
    result.mirrors.push_back(m);
    result.turned_by.push_back(-1);
  }
  for (Index v : group.vertices) conditions[v].push_back({normal, 0.0});
}

/// Columns: the directions that x, y and z of a displacement support mean at vertex v.
Mat3 support_axes(const mesh::SurfaceMesh& mesh, const Support& support, Index v) {
  Mat3 axes = Mat3::Identity();
  const double tolerance = 1e-9;
  if (support.cylinder_axis) {
    axes.col(2) = support.cylinder_axis->normalized();
    const Vec3 from_centre = mesh.positions()[v] - support.cylinder_centre;
    const Vec3 radial = from_centre - from_centre.dot(axes.col(2)) * axes.col(2);
    if (radial.norm() <= tolerance * mesh.extent())
      throw UserError(
          fmt::format("{}: vertex {} lies on the axis of the cylinder, where nothing is radial; move the "
                      "axis, or support that vertex in global axes",
                      name_of(support), mesh.data().vertex_tags[v]));
    axes.col(0) = radial.normalized();
    axes.col(1) = Vec3(axes.col(2)).cross(Vec3(axes.col(0)));
  } else if (support.x_axis) {
    axes.col(0) = support.x_axis->normalized();
    const Vec3 second = support.y_axis ? *support.y_axis : Vec3(axes.col(0)).unitOrthogonal();
    const Vec3 across = second - second.dot(axes.col(0)) * axes.col(0);
    if (across.norm() <= tolerance * second.norm())
      throw UserError(name_of(support) + ": y_axis is parallel to x_axis; give another direction");
    axes.col(1) = across.normalized();
    axes.col(2) = Vec3(axes.col(0)).cross(Vec3(axes.col(1)));
  }
  return axes;
}

/// The slopes round a clamped surface, where the sheet ends there: not in the mesh of a remeshed run.
void add_border(const mesh::SurfaceMesh& mesh, const mesh::Group& group, int turned_by, Constraints& result) {
  const std::vector<mesh::Segment> border = mesh::inner_border(mesh, group);
  std::set<std::pair<Index, int>> held;
  for (const mesh::MirrorSide& m : result.mirrors) held.emplace(m.triangle, m.side);
  for (const mesh::Joint& joint : mesh.joints()) {
    if (!std::ranges::binary_search(border, joint.edge)) continue;
    for (const mesh::TriangleSide& side : joint.sides) {
      if (!held.emplace(side.triangle, side.side).second) continue;
      const Vec3 normal = mesh.start_normal(side.triangle);
      result.mirrors.push_back({side.triangle, side.side, 2.0 * normal * normal.transpose() - Mat3::Identity()});
      result.turned_by.push_back(turned_by);
    }
  }
}

/// `number`: of the support.
void add_fixed(const mesh::SurfaceMesh& mesh, const Support& support, int number, Constraints& result,
               Conditions& conditions) {
  const mesh::Group& group = mesh.group(support.group);
  const bool slides = support.kind == Support::Kind::sliding;
  if (slides && group.dimension != 1)
    throw UserError(name_of(support) + ": the slope is held across edges; name a curve group of boundary edges");
  if ((support.kind == Support::Kind::clamped || slides) && group.dimension == 1)
    for (mesh::MirrorSide& m : boundary_sides(mesh, group, support)) {
      const Vec3 normal = mesh.start_normal(m.triangle);
      m.reflection = 2.0 * normal * normal.transpose() - Mat3::Identity();
      result.mirrors.push_back(m);
      result.turned_by.push_back(support.rotation ? number : -1);
    }
  if (support.kind == Support::Kind::clamped && group.dimension == 2)
    add_border(mesh, group, support.rotation ? number : -1, result);
  if (support.kind == Support::Kind::clamped && group.dimension == 0)
    throw UserError(name_of(support) + ": a point has no slope to clamp; use `hinged`, or name a curve group");
  const bool all = support.kind != Support::Kind::displacement && !slides;
  for (Index v : group.vertices) {
    const Mat3 axes = all ? Mat3(Mat3::Identity()) : support_axes(mesh, support, v);
    for (int i = 0; i < 3; ++i)
      if (all || support.components[i]) conditions[v].push_back({axes.col(i), support.value[i]});
  }
}

/// Axes of a vertex: an orthonormal basis whose first columns span the directions, the global axes where they fit.
Mat3 axes_of(const Eigen::Matrix3Xd& span, std::array<bool, 3>& fixed) {
  const auto rank = span.cols();
  for (int mask = 0; mask < 8; ++mask) {  // global axes?
    Eigen::Index count = 0;
    bool fits = true;
    for (int i = 0; i < 3; ++i) {
      const double part = (span.transpose() * Vec3::Unit(i)).norm();
      if (mask & (1 << i)) ++count;
      fits = fits && std::abs(part - ((mask & (1 << i)) ? 1.0 : 0.0)) < 1e-12;
    }
    if (!fits || count != rank) continue;
    for (int i = 0; i < 3; ++i) fixed[i] = (mask & (1 << i)) != 0;
    return Mat3::Identity();
  }
  for (int i = 0; i < 3; ++i) fixed[i] = i < rank;
  Mat3 q;
  q.col(0) = span.col(0);
  q.col(1) = rank == 2 ? Vec3(span.col(1)) : Vec3(span.col(0).unitOrthogonal());
  q.col(2) = Vec3(q.col(0)).cross(Vec3(q.col(1)));
  return q;
}

VertexSupport combine(const mesh::SurfaceMesh& mesh, Index v, const std::vector<Condition>& conditions) {
  Eigen::MatrixX3d directions(static_cast<Eigen::Index>(conditions.size()), 3);
  Eigen::VectorXd values(directions.rows());
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    directions.row(static_cast<Eigen::Index>(i)) = conditions[i].direction.transpose();
    values[static_cast<Eigen::Index>(i)] = conditions[i].value;
  }
  const SingularValues svd = singular_value_decomposition(directions);
  const Eigen::Index rank = svd.rank(1e-8);
  const Vec3 displacement = svd.v.leftCols(rank) * svd.values.head(rank).cwiseInverse().asDiagonal() *
                            svd.u.leftCols(rank).transpose() * values;
  if ((directions * displacement - values).norm() > 1e-12 * (1.0 + values.norm()))
    throw UserError(fmt::format(
        "[[support]]: contradicting displacements are prescribed at vertex {} ({}, {}, {}); "
        "remove one of the supports that hold it",
        mesh.data().vertex_tags[v], mesh.positions()[v].x(), mesh.positions()[v].y(), mesh.positions()[v].z()));
  VertexSupport s;
  s.axes = axes_of(svd.v.leftCols(rank), s.fixed);
  s.value = s.axes.transpose() * displacement;
  return s;
}

/// Components of a vertex that a support moves: those that it holds, or all where the axes of the two are not the global ones.
std::array<bool, 3> moved_components(const Support& s, const VertexSupport& at) {
  const bool own_axes = s.x_axis || s.y_axis || s.cylinder_axis || at.rotated();
  const bool by_component = s.kind == Support::Kind::displacement || s.kind == Support::Kind::sliding;
  return own_axes || !by_component ? std::array<bool, 3>{true, true, true} : s.components;
}

bool move_alike(const Support& a, const Support& b) {
  return (a.follows && b.follows) || (!a.motion_text.empty() && a.motion_text == b.motion_text);
}

void move_vertex(const mesh::SurfaceMesh& mesh, const std::vector<Support>& supports, std::size_t i, Index v,
                 VertexSupport& at) {
  const std::array<bool, 3> moved = moved_components(supports[i], at);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!moved[k]) continue;
    int& motion = at.motion[k];
    if (motion >= 0 && !move_alike(supports[i], supports[static_cast<std::size_t>(motion)]))
      throw UserError(fmt::format("{} and {}: both move vertex {}; let one of them do it", name_of(supports[i]),
                                  name_of(supports[static_cast<std::size_t>(motion)]), mesh.data().vertex_tags[v]));
    motion = static_cast<int>(i);
  }
}

/// Throws where a support holds still what another one moves, as far as a few times tell.
void require_stillness(const mesh::SurfaceMesh& mesh, const std::vector<Support>& supports, const Support& still,
                       Index v, const VertexSupport& at) {
  const std::array<bool, 3> held = moved_components(still, at);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!held[k] || at.motion[k] < 0 || at.rotated()) continue;
    const Support& mover = supports[static_cast<std::size_t>(at.motion[k])];
    if (mover.follows) continue;
    for (const double t : {1e-3, 0.37, 1.0})
      if (std::abs(mover.motion(mesh.positions()[v], t)[static_cast<Eigen::Index>(k)]) > 0.0)
        throw UserError(
            fmt::format("{} moves vertex {}, which {} holds; leave it out of one of them, or give both the same motion",
                        name_of(mover), mesh.data().vertex_tags[v], name_of(still)));
  }
}

}  // namespace

Constraints resolve_supports(const mesh::SurfaceMesh& mesh, const std::vector<Support>& supports) {
  Constraints result;
  Conditions conditions;
  for (std::size_t i = 0; i < supports.size(); ++i) {
    if (supports[i].kind == Support::Kind::symmetry)
      add_symmetry(mesh, supports[i], result, conditions);
    else
      add_fixed(mesh, supports[i], static_cast<int>(i), result, conditions);
  }
  for (const auto& [v, list] : conditions) result.vertices.emplace(v, combine(mesh, v, list));
  for (std::size_t i = 0; i < supports.size(); ++i) {
    if (!supports[i].motion && !supports[i].follows) continue;
    for (Index v : mesh.group(supports[i].group).vertices) move_vertex(mesh, supports, i, v, result.vertices.at(v));
  }
  for (const Support& s : supports)
    if (!s.motion && !s.follows && s.kind != Support::Kind::symmetry && !s.x_axis && !s.cylinder_axis)
      for (Index v : mesh.group(s.group).vertices)
        if (const auto at = result.vertices.find(v); at != result.vertices.end())
          require_stillness(mesh, supports, s, v, at->second);
  return result;
}

Vec3 mirror_normal(const mesh::SurfaceMesh& mesh, const Support& symmetry) {
  const mesh::Group& group = mesh.group(symmetry.group, 1);
  return symmetry_normal(mesh, group, boundary_sides(mesh, group, symmetry), symmetry);
}

std::vector<std::array<Index, 2>> pairs_of(const mesh::SurfaceMesh& mesh, const Spring& spring) {
  std::vector<std::array<Index, 2>> pairs;
  if (spring.kind != Spring::Kind::pair) return pairs;
  const auto& x = mesh.positions();
  const std::vector<Index>& others = mesh.group(spring.to).vertices;
  for (Index v : mesh.group(spring.group).vertices) {
    const Index nearest = *std::min_element(others.begin(), others.end(), [&](Index a, Index b) {
      return (x[a] - x[v]).squaredNorm() < (x[b] - x[v]).squaredNorm();
    });
    if (nearest == v)
      throw UserError(fmt::format("[[spring]] type 'pair': vertex {} is in '{}' and in '{}': it cannot pull at itself",
                                  mesh.data().vertex_tags[v], spring.group, spring.to));
    pairs.push_back({v, nearest});
  }
  return pairs;
}

}  // namespace voile::system

// From groups to rigid bodies: members, carriers, what is fixed, and the edges whose slope turns with them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "constraints.hpp"
#include "mesh/group_weights.hpp"
#include "voile/errors.hpp"

namespace voile::system {

namespace {

std::string name_of(const RigidGroup& g) {
  return fmt::format("[[rigid]] group '{}'", g.group);
}

std::string place_of(const mesh::SurfaceMesh& mesh, Index v) {
  const Vec3& x = mesh.positions()[v];
  return fmt::format("vertex {} ({:.6g}, {:.6g}, {:.6g})", mesh.data().vertex_tags[v], x.x(), x.y(), x.z());
}

std::vector<mesh::TriangleSide> held_slopes(const mesh::SurfaceMesh& mesh, const RigidGroup& g,
                                            const mesh::Group& group) {
  std::vector<mesh::TriangleSide> sides;
  if (!g.slope || group.dimension != 1) return sides;
  for (const mesh::Segment& segment : group.segments)
    for (const Index t : mesh.triangles_of_vertex(segment[0])) {
      const int s = mesh.side_of(t, segment[0], segment[1]);
      if (s < 0) continue;
      const auto fail = [&](const char* why) {
        throw UserError(fmt::format("{}: the edge {}-{} {}; give slope = \"free\", or name the surface beside it",
                                    name_of(g), mesh.data().vertex_tags[segment[0]],
                                    mesh.data().vertex_tags[segment[1]], why));
      };
      if (mesh.neighbour(t, s) != no_index) fail("lies inside the surface, where no slope is held");
      for (int k = 0; k < 3; ++k)
        if (mesh.is_joint(t, k)) fail("is an edge of a triangle at a joint of sheets, whose slope cannot be held");
      sides.push_back({t, s});
    }
  return sides;
}

/// A group on a line turns about it without moving anything, unless slopes turn with it.
void refuse_idle_turn(const mesh::SurfaceMesh& mesh, const RigidGroup& g, const RigidBody& body) {
  constexpr double round_off = 1e-9;
  if (!body.slopes.empty() || g.turn == RigidGroup::Turn::held || g.angle) return;
  const Vec3& first = mesh.positions()[body.members.front()];
  Vec3 line = Vec3::Zero();
  for (const Index v : body.members)
    if (const Vec3 d = mesh.positions()[v] - first; d.squaredNorm() > line.squaredNorm()) line = d;
  const double size = line.squaredNorm();
  const auto is_on = [&](const Vec3& x) { return (x - first).cross(line).norm() <= round_off * size; };
  if (!std::all_of(body.members.begin(), body.members.end(), [&](Index v) { return is_on(mesh.positions()[v]); }))
    return;
  if (g.axis && (g.axis->cross(line).norm() > round_off * g.axis->norm() * line.norm() || !is_on(body.point))) return;
  throw UserError(fmt::format(
      "{}: its vertices lie on a line, and nothing resists a turn about it; give turn = "
      "\"held\", turn = \"about\" with another axis, or slope = \"held\" on a boundary, or name the surface",
      name_of(g)));
}

RigidBody make_body(const mesh::SurfaceMesh& mesh, const RigidGroup& g) {
  RigidBody body;
  const mesh::Group* group = nullptr;
  try {
    group = &mesh.group(g.group);
  } catch (const UserError& e) {
    throw UserError(fmt::format("[[rigid]] group: {}", e.what()));
  }
  body.members = group->vertices;
  std::sort(body.members.begin(), body.members.end());
  if (body.members.size() < 3)
    throw UserError(
        fmt::format("{}: a rigid group needs three or more vertices and this one has {}: refine the mesh there, "
                    "or use [[support]]",
                    name_of(g), body.members.size()));
  std::copy_n(body.members.begin(), 3, body.carriers.begin());
  Vec3 centre = Vec3::Zero();
  const std::vector<double> weights = mesh::group_weights(mesh, *group);
  for (std::size_t i = 0; i < weights.size(); ++i) centre += weights[i] * mesh.positions()[group->vertices[i]];
  body.point = g.point.value_or(centre);
  double squares = 0.0;
  for (const Index v : body.members) squares += (mesh.positions()[v] - body.point).squaredNorm();
  body.length = 2.0 * std::sqrt(squares / static_cast<double>(body.members.size()));
  if (g.axis) {
    body.basis.col(0) = g.axis->normalized();
    body.basis.col(1) = Vec3(body.basis.col(0)).unitOrthogonal();
    body.basis.col(2) = Vec3(body.basis.col(0)).cross(Vec3(body.basis.col(1)));
  }
  body.mass = g.mass;
  body.place = g.place;
  body.slopes = held_slopes(mesh, g, *group);
  refuse_idle_turn(mesh, g, body);
  return body;
}

/// Everything but the unknowns of the body.
void fix(const RigidGroup& g, const RigidBody& body, Constraints& constraints) {
  using Turn = RigidGroup::Turn;
  for (const Index v : body.members) constraints.vertices[v].fixed = {true, true, true};
  const bool turns = g.turn == Turn::free, swings = turns || (g.turn == Turn::about && !g.angle);
  constraints.vertices[body.carriers[0]].fixed = g.held;
  constraints.vertices[body.carriers[1]].fixed = {!swings, !turns, !turns};
  constraints.vertices[body.carriers[2]].fixed = {!swings, true, true};
}

}  // namespace

void resolve_rigid_groups(const mesh::SurfaceMesh& mesh, const std::vector<RigidGroup>& groups,
                          Constraints& constraints) {
  std::map<Index, std::size_t> of;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    RigidBody body = make_body(mesh, groups[i]);
    for (const Index v : body.members) {
      const auto [at, is_new] = of.emplace(v, i);
      if (!is_new)
        throw UserError(fmt::format("{} and {}: both have {}; join the groups, or leave the vertex out of one of them",
                                    name_of(groups[at->second]), name_of(groups[i]), place_of(mesh, v)));
      if (constraints.vertices.count(v) > 0)
        throw UserError(
            fmt::format("{}: {} is held by a [[support]] too; hold the reference point by `translation` and `turn` "
                        "instead, and leave the vertex out of the support",
                        name_of(groups[i]), place_of(mesh, v)));
    }
    constraints.bodies.push_back(std::move(body));
  }
  for (const mesh::MirrorSide& m : constraints.mirrors)
    for (const Index v : mesh.triangles()[m.triangle])
      if (of.count(v) > 0)
        throw UserError(
            fmt::format("{}: {} belongs to a triangle at a clamped or mirrored edge; leave a row of cells between",
                        name_of(groups[of.at(v)]), place_of(mesh, v)));
  for (std::size_t i = 0; i < groups.size(); ++i) fix(groups[i], constraints.bodies[i], constraints);
}

}  // namespace voile::system

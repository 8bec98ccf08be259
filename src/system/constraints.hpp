// Supports resolved on a mesh: fixed components of each vertex in local axes, and mirrored boundary sides.
//
// A vertex v with supports in directions d_1, d_2, ... has axes Q_v (columns) whose first components are fixed: the
// unknown of the vertex is a_v = Q_v^T u_v. Q_v is the identity unless a direction is oblique to the global axes.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "conditions.hpp"
#include "mesh/patch.hpp"
#include "mesh/surface_mesh.hpp"
#include "rigid_bodies.hpp"
#include "ties.hpp"

namespace voile::system {

struct VertexSupport {
  Mat3 axes = Mat3::Identity();  ///< Q_v
  std::array<bool, 3> fixed{false, false, false};
  Vec3 value = Vec3::Zero();  ///< prescribed components in local axes at load factor 1 [m]
  /// Numbers of the supports that move it in time along its axes; -1: none.
  std::array<int, 3> motion{-1, -1, -1};
  [[nodiscard]] bool moves() const { return motion != std::array<int, 3>{-1, -1, -1}; }
  [[nodiscard]] bool rotated() const { return !axes.isIdentity(0.0); }
};

struct Constraints {
  std::map<Index, VertexSupport> vertices;
  std::vector<mesh::MirrorSide> mirrors;
  std::vector<int> turned_by;  ///< per mirror, then their images: number of the support that turns it in time, or -1
  std::vector<RigidBody> bodies;
  std::vector<mesh::TriangleSide> elastic{};  ///< sides that hinges hold against the ground
  Ties ties{};
};

/// Throws UserError for unknown groups, clamped or symmetric curves that are not boundary edges, a symmetry plane that
/// cannot be found, and supports that contradict each other.
[[nodiscard]] Constraints resolve_supports(const mesh::SurfaceMesh& mesh, const std::vector<Support>& supports);

/// Pairs of vertices that a spring of kind `pair` joins: each vertex of its group with the nearest one of its other
/// group at the start (of equally near ones the first in the mesh); none for other kinds. Throws UserError for unknown
/// groups and for a vertex that is its own partner. Not collective.
[[nodiscard]] std::vector<std::array<Index, 2>> pairs_of(const mesh::SurfaceMesh& mesh, const Spring& spring);

}  // namespace voile::system

// What a surface has around its vertices and edges, for ties.
#pragma once

#include <array>
#include <map>
#include <set>
#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::geometry {

inline constexpr double tie_same_shape = 0.02;  ///< of the shortest edge: by how much a shape may change
inline constexpr double tie_near = 0.3;         ///< of the shortest edge: what is nearer moves

struct TieSurface {
  std::vector<std::vector<Index>> star;                ///< triangles of each vertex
  std::map<mesh::Segment, std::vector<Index>> around;  ///< triangles of each edge (ascending)
  std::set<mesh::Segment> lines;  ///< edges that must stay: rims, joints, those of groups and between groups
  std::map<mesh::Segment, std::vector<std::size_t>> named;  ///< groups of curves that have an edge
  std::vector<double> size;                                 ///< shortest edge of each vertex [m]
  std::vector<char> fixed;                                  ///< whether a vertex is a group's point
};

/// `rims`: edges that were on rims of parts before those were merged, and still are lines.
[[nodiscard]] TieSurface surface_of(const mesh::MeshData& data, const std::vector<mesh::Segment>& rims = {});
/// Edges on a rim now, and `rims`. In order.
[[nodiscard]] std::vector<mesh::Segment> all_rims(const mesh::MeshData& data, const std::vector<mesh::Segment>& rims);

[[nodiscard]] std::array<Vec3, 3> corners_of(const mesh::MeshData& data, Index triangle);
[[nodiscard]] double distance_to_triangle(const Vec3& p, const std::array<Vec3, 3>& corners);
/// Part of the way from a to b where p is nearest, from 0 to 1.
[[nodiscard]] double station(const Vec3& p, const Vec3& a, const Vec3& b);
[[nodiscard]] double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b);

/// Moves vertices onto those and onto rims of other parts that are near. Returns how many moved.
Index move_to_rims(mesh::MeshData& data, double tolerance, std::vector<mesh::Segment>& rims);

/// Whether a vertex can move to y [m] while the sheet and its lines stay where they are. `onto`: the vertex that it becomes, if any.
[[nodiscard]] bool may_move(const mesh::MeshData& data, const TieSurface& s, Index p, const Vec3& y, double tolerance,
                            Index onto = no_index);

/// Makes the smallest angles of triangles that have one of the vertices larger: turns sides of pairs of triangles, and joins
/// vertices that are close to each other.
void improve_angles(mesh::MeshData& data, const std::set<Index>& vertices, double tolerance);

}  // namespace voile::geometry

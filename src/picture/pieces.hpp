// Parts of what is shown: bodies and floors among obstacles, panels and borders of groups; private to src/picture.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mesh/surface_mesh.hpp"
#include "results/results.hpp"

namespace voile::picture {

/// Obstacles as they are looked at. A half-space is stored as a square far larger than the sheet: a level one is the ground
/// itself, others are drawn, but the picture need not hold them.
struct Bodies {
  std::vector<mesh::Triangle> triangles;  ///< to draw; vertices as in the obstacles
  std::vector<Vec3> solid_points;         ///< vertices of bodies [m]
  std::optional<double> floor;            ///< height of a level half-space along `up` [m]
};
[[nodiscard]] Bodies find_bodies(const results::ObstacleTriangles& obstacles, const std::vector<Vec3>& positions,
                                 const Vec3& up);

/// Bit s of a triangle: its side s is a line of a group, or the border of a group of triangles, or a seam.
[[nodiscard]] std::vector<std::uint8_t> group_borders(const mesh::MeshData& mesh);

/// Bit s of a triangle: its side s is a segment of the seam that CSV files call so.
[[nodiscard]] std::vector<std::uint8_t> seam_sides(const mesh::MeshData& mesh, const std::string& seam);

/// Bit s of a triangle: at its side s the sheet is folded by more than `angle` [rad].
[[nodiscard]] std::vector<std::uint8_t> folded_sides(const mesh::MeshData& mesh, const std::vector<Vec3>& positions,
                                                     double angle);

/// Number of the panel of each triangle: the group of triangles that it is in; without such groups the piece of the
/// texture.
[[nodiscard]] std::vector<std::size_t> panels_of(const mesh::MeshData& mesh);

}  // namespace voile::picture

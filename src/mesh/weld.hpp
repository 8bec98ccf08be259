// Open seams are closed: pairs of vertices become one.
//
// Symbols   m_v   mass of vertex v [kg]      of the vertices that become one: x = sum m_v x_v / sum m_v, for places,
//           displacements and velocities alike, so that mass, its centre and momentum stay
#pragma once

#include <array>
#include <string>
#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

/// The vertex that each old one becomes, and the mesh that this gives.
struct Welded {
  MeshData
      data;  ///< other seams are still open; every triangle keeps its rest corners, its number and its corners' order
  std::vector<Index> target;
};

/// Name of the curve group with the edges of both sides of a seam, which stays when it is welded.
[[nodiscard]] std::string seam_group(const std::string& seam);

/// Those of the named seams that are open; "all" means every one, `*` any text.
[[nodiscard]] std::vector<std::string> open_seams(const MeshData& mesh, const std::vector<std::string>& names);

/// Closes seams. `places`: of the vertices, which become the positions of the new mesh [m]; `mass` per vertex, at least
/// one of those that become one > 0 [kg]. Not collective. Throws UserError if a triangle loses its area.
[[nodiscard]] Welded weld(const MeshData& mesh, const std::vector<std::string>& seams, const std::vector<Vec3>& places,
                          const std::vector<double>& mass);

/// Means of values per vertex, `width` each, in the new numbers.
[[nodiscard]] std::vector<double> merged_means(const std::vector<Index>& target, const std::vector<double>& mass,
                                               const std::vector<double>& values, std::size_t width);

/// The widest place of open seams.
struct SeamGap {
  std::string seam;
  double gap = 0.0;  ///< [m]; 0 if no seam is open
  std::array<Index, 2> pair{no_index, no_index};
  Vec3 place = Vec3::Zero();
};
[[nodiscard]] SeamGap widest_gap(const MeshData& mesh, const std::vector<std::string>& seams,
                                 const std::vector<Vec3>& places);

/// Rest lengths of the two sides of an open seam [m], from its group; zeros if there is no such seam or group. Not
/// collective.
[[nodiscard]] std::array<double, 2> side_lengths(const SurfaceMesh& mesh, const std::string& seam);

/// Per vertex the lowest of those that it becomes one with when the named seams are closed; empty if none of them is open.
[[nodiscard]] std::vector<Index> joined_vertices(const MeshData& mesh, const std::vector<std::string>& seams = {"all"});

}  // namespace voile::mesh

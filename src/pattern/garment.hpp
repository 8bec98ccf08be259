// A garment: panels cut into triangles, in their places, with open seams.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "marks.hpp"
#include "mesh/surface_mesh.hpp"
#include "seams.hpp"

namespace voile::pattern {

struct Garment {
  std::vector<Panel> panels;
  Seams seams;
  /// One chart per panel (the pieces side by side, so that no two lie on each other), the coordinates of the pieces as
  /// texture [m], turned until their grain line is along y, positions as placed. Groups: each panel by its name, each edge as "PANEL/number", and "PANEL/label"
  /// for the edges that have a label, both sides of each seam as "seam NAME", each mark. All seams are open.
  mesh::MeshData mesh;
};

/// Cuts, meshes and places panels. Not collective: call on one rank. Throws UserError: resolve_seams(), cells too coarse
/// for an outline, seams that would fold cells onto themselves or join three edges, a mark with the name of another group.
[[nodiscard]] Garment make_garment(std::vector<Panel> panels, const std::vector<SeamRequest>& seams,
                                   const std::vector<MarkRequest>& marks = {});

/// Names of the edges that are in several seams, and of these seams.
[[nodiscard]] std::map<std::string, std::vector<std::string>> layered_edges(const Garment& garment);

/// Panels with areas and masses, seams with the lengths of both sides and their distance, and how much fabric it takes,
/// as lines of text. Per panel: `densities` [kg/m^2], area of `allowances` of its seams [m^2]. Not collective.
[[nodiscard]] std::string garment_text(const Garment& garment, const std::vector<double>& densities,
                                       const std::vector<double>& allowances);

}  // namespace voile::pattern

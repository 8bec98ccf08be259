// Gathers: the rest shape of fabric beside a seam whose one side is longer than the other.
//
// Symbols   L, l  lengths of two edges that meet in a seam, L > l                                               [m]
//           k     = l/L, by how much the longer side is drawn in along the seam
//           y     distance from the seam in the chart,  w  width of the gathered rows                            [m]
//           c(y)  = 1 - (1 - k) max(0, 1 - y/w), what remains of a length along the seam
// The folds that a gathering thread makes are finer than cells. Where they are, fabric is as long as the seam, and takes
// up what is left over in folds that cells resolve only from w on. So edges get the rest lengths of the metric
// c(y)^2 dx^2 + dy^2, those of the seam exactly l, and each triangle beside the seam is a chart of its own with these
// lengths. Rest lengths are all that changes: mass, areas and what is measured are those of the flat pieces.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

struct Gather {
  std::string seam;          ///< whether open or welded
  double least_ratio = 1.0;  ///< L/l of two edges from which on the longer is gathered
  double width = 0.0;        ///< w [m]; 0: three rows of the cells beside each node of the seam
};

struct Gathered {
  MeshData mesh;                   ///< as it was, with the rest shape of the gathered fabric
  std::vector<std::string> seams;  ///< of which an edge is gathered
};

/// The width that three rows of cells have on average, so that a finer mesh gathers the same fabric [m]; 0 if no edge of
/// the seam is gathered. Not collective.
[[nodiscard]] double gather_width(const SurfaceMesh& mesh, const Gather& gather);

/// Nothing if no edge is gathered. Not collective.
[[nodiscard]] std::optional<Gathered> gathered(const SurfaceMesh& mesh, const std::vector<Gather>& seams);

}  // namespace voile::mesh

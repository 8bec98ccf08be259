// A periodic sheet: pairs of boundary curves that differ by a translation, and the surface continued beyond them.
//
// Symbols   T_i    translation from curve `from` of pair i to its curve `to`                                    [m]
//           r, n   root of a vertex: the one that it repeats, and by how many periods:  X = X_r + sum n_i T_i
// Vertices of curves `to` repeat those of `from`. The continued surface has the triangles of the mesh first, then images of
// them within some rings of the curves, so that a triangle at a curve has a neighbour there as everywhere else.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "surface_mesh.hpp"

namespace voile::mesh {

/// Names of two curve groups.
struct PeriodicCurves {
  std::string from, to;
};

struct ContinuedSurface {
  static constexpr std::size_t most = 3;  ///< pairs
  using Shift = std::array<int, most>;    ///< n
  std::vector<Vec3> translations;         ///< T_i [m]
  std::vector<Index> root;                ///< per vertex, those of the mesh first
  std::vector<Shift> shift;               ///< likewise
  std::vector<Index> original;            ///< per triangle: that of the mesh of which it is an image, or itself
  std::unique_ptr<const SurfaceMesh> surface;
};

/// `rings`: of vertices around the curves. Throws UserError for curves that are no pair, and for surfaces that cannot be
/// continued.
[[nodiscard]] ContinuedSurface continue_periodically(const SurfaceMesh& mesh, const std::vector<PeriodicCurves>& pairs,
                                                     int rings);

}  // namespace voile::mesh

// How long the edges of a mesh should be, from the curvature of the sheet. Theory: docs/theory/remeshing.md (1).
//
// Symbols   kappa   largest principal curvature of a triangle [1/m]
//           h       wanted edge length at a vertex [m]
//           delta   wanted angle between neighbouring triangles, per edge [rad]
//           R       radius of a boundary curve at rest [m]
//   h_v = clamp( delta / sqrt( mean of kappa^2 over the triangles of v, by area ) ; smallest, largest )
//   on curved free edges also h <= R/10: a polygon of edges h falls short of the area by (h/R)^2/6
//   then |h_a - h_b| <= growth |X_a - X_b| along edges, by lowering h only
// The square before the mean: a fold inside a ring is seen with its full strength. A bound from contact, velocity or the
// user lowers h before the grading, below `smallest` too only if the bound itself says so.
#pragma once

#include <vector>

#include "mesh/surface_mesh.hpp"

namespace voile::adapt {

struct SizeOptions {
  double angle = 0.25;    ///< delta [rad]
  double smallest = 0.0;  ///< [m]
  double largest = 0.0;   ///< [m]; 0: no bound
  double growth = 0.3;    ///< largest slope of h over distance
};

/// Wanted edge length of every vertex [m]. `places` per vertex [m]: where they are;
/// `curvature_squared` per triangle [1/m^2]; `bound` per vertex [m], infinity where there is none, or empty.
/// Not collective. Throws InternalError if lengths of arrays do not fit or options are out of range.
[[nodiscard]] std::vector<double> size_field(const mesh::SurfaceMesh& mesh, const std::vector<Vec3>& places,
                                             const std::vector<double>& curvature_squared,
                                             const std::vector<double>& bound, const SizeOptions& options);

/// Edge lengths of every vertex [m] for which the error of the stress resultants is `wanted` times the stored energy, and the same in
/// every cell. With e_T the error per area of a triangle T of area A and edge l, sum_T A e_T the whole, and e of the second order in the edge:
///   h_T = l sqrt( wanted stored / (eta_T sum eta) ) >= l/2,  eta_T = sqrt(A e_T);  1/h_v^2 = mean of 1/h_T^2 over the triangles of v, by area
/// What a coarse mesh says of a much finer one is not to be relied on, hence the half.
/// `density`: e_T per triangle [J/m^2]; `stored` [J]. Infinite where nothing is wrong, and everywhere if `stored` is 0. Not collective.
/// Source: Zienkiewicz & Zhu, Int. J. Numer. Meth. Engng 24 (1987) 337-357.
[[nodiscard]] std::vector<double> sizes_for_error(const mesh::SurfaceMesh& mesh, const std::vector<double>& density,
                                                  double stored, double wanted);

/// How well the edges meet the wanted sizes. L: rest length of an edge, h: mean of the sizes at its ends.
struct SizeMatch {
  double too_long = 0.0;   ///< fraction of vertices whose mean of L/h over its edges is above 1.5
  double too_short = 0.0;  ///< fraction of vertices whose mean is below 0.5
  double p1 = 0.0, p10 = 0.0, p50 = 0.0, p90 = 0.0, p99 = 0.0;  ///< percentiles of L/h over edges, 0 if none counts
  double smallest = 0.0, largest = 0.0;                         ///< of the wanted sizes [m]
};

/// `counted` per vertex: which ones the fractions, of all vertices, and the percentiles count (edges with both ends); empty:
/// all. Not collective. Throws InternalError if an array is not per vertex.
[[nodiscard]] SizeMatch match(const mesh::SurfaceMesh& mesh, const std::vector<double>& size,
                              const std::vector<char>& counted = {});

}  // namespace voile::adapt

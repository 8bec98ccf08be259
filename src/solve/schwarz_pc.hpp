// PC type "voile_schwarz": many small factors in single precision and a coarse level of rigid motions, for conjugate
// gradients on the tangents of plates too large for one factor: -ksp_type cg -ksp_rtol 1e-8 -pc_type voile_schwarz.
//
// Symbols   A     symmetric positive definite AIJ matrix of full 3x3 blocks, distributed by block rows
//           R_s   restriction to subdomain s: a part of a rank's vertices (METIS, -pc_schwarz_vertices 400) with those that
//                 they couple to (-pc_schwarz_overlap 1 times)
//           Z     rigid motions of aggregates of vertices (METIS, -pc_schwarz_aggregate 50), times shares that sum to one: the
//                 indicator of the aggregate, averaged over the neighbours (-pc_schwarz_smoothing 3 times). The averaging
//                 matters: shares that jump bend a plate sharply.
//           E     = Z^T A Z, factored by MUMPS in double;  Q = Z E^-1 Z^T
//           M     = sum_s R_s^T (R_s A R_s^T)^-1 R_s
// Preconditioner   (I - Q A) M (I - A Q) + Q   (balancing, as in src/solve/coarse_space.hpp).
// Iterations do not grow with the number of subdomains or of ranks, and memory grows with the number of vertices alone.
// Subdomains of an indefinite matrix may come out indefinite; conjugate gradients then say so. Negative pivots are not known.
#pragma once

#include <petscksp.h>

namespace voile::solve {

inline constexpr const char* schwarz_pc_type = "voile_schwarz";

/// Makes the type known to PETSc; again does nothing. It needs the places of the own vertices, three coordinates each, by
/// PCSetCoordinates (LinearSolver gives them); what it builds next is for the last ones given.
void register_schwarz_pc();

}  // namespace voile::solve

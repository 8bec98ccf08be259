// PC type "voile_block_icc": incomplete Cholesky factor without fill of 3 x 3 blocks, for conjugate gradients.
//
// For symmetric AIJ matrices of block size 3 in full blocks, as tangents are: -ksp_type cg -pc_type voile_block_icc. Each
// rank factors its own rows with those of other ranks that they couple to, and what the ranks find there is added (additive
// Schwarz, src/linear/overlapping_part.hpp); with -pc_block_icc_overlap 0 its own diagonal part alone (block Jacobi). In reverse
// Cuthill-McKee order unless -pc_block_icc_ordering_type names another of PETSc's. Where a part comes out indefinite, a fraction of the
// diagonal blocks is added until it does not; so the preconditioner is positive definite whatever the matrix is. With
// -pc_block_icc_aggregates N a coarse level of the translations of about N aggregates of vertices is solved exactly
// (balancing, src/linear/coarse_space.hpp); matrices that are not positive definite there go without it. Works
// without allocation while the pattern holds.
#pragma once

#include <petscksp.h>

namespace voile::linear {

inline constexpr const char* block_icc_pc_type = "voile_block_icc";

/// Makes the type known to PETSc; again does nothing.
void register_block_icc_pc();
/// Fraction of the diagonal blocks to add from the start, as -pc_block_icc_shift. Before the first set-up.
void set_block_icc_shift(PC pc, double shift);
/// Aggregates of the coarse level, 0 (the start) for none, as -pc_block_icc_aggregates. Before the first set-up.
void set_block_icc_aggregates(PC pc, int aggregates);
/// Whether a part that comes out indefinite is shifted more, which is the default, or is a failure (PCGetFailedReason).
void allow_block_icc_shifts(PC pc, bool allowed);
/// Largest fraction of the diagonal that some rank has added in the last factorisation. The same on all ranks.
[[nodiscard]] double block_icc_shift(PC pc);
/// Matrices so far of which some rank had to shift its part. The same on all ranks.
[[nodiscard]] long block_icc_shifted(PC pc);

}  // namespace voile::linear

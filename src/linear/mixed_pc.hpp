// PC type "voile_mixed": a direct solver for symmetric matrices that factors in single precision and answers in double.
//
// K ~ L L^T by MUMPS in single precision, in nested-dissection order; K x = b by conjugate gradients on the double
// matrix with that factor as preconditioner: two to four iterations where inertia makes K well conditioned. Where round-off
// has made L L^T indefinite, as it does on fine plates in statics, K + s diag(K) is factored, s = 1.2e-7 and then 1e-6: some
// tens of iterations, of which five times as many are allowed. Where they
// do not converge, K is factored in double, and so are the next ones. Tuned by -mixed_ksp_rtol, -mixed_ksp_max_it
// and so on; the double factor by -mixed_double_mat_mumps_icntl_..., -pc_mixed_on_disk keeps the single one in files. From 60 000 rows on
// the single factor is compressed, with as many iterations.
#pragma once

#include <petscksp.h>

namespace voile::linear {

inline constexpr const char* mixed_pc_type = "voile_mixed";

/// Makes the type known to PETSc; again does nothing.
void register_mixed_pc();
/// From now on in double only, where round-off counts. Not collective.
void set_mixed_double(PC pc);
/// For statics: negative pivots are those of the matrix, not of its factor after round-off, and two failures of single precision
/// are enough for the rest to be factored in double. Conjugate gradients with a right side drawn at random then either
/// meet negative curvature, which is factored in double and counted, or miss a negative mode with a probability of
/// rtol sqrt(2 n/pi), n rows: 4e-6 for 1e5 vertices. Not collective.
void set_mixed_proves(PC pc);
/// Of the last factorisation, in whichever precision; -1 if unknown, as with a shift. Collective.
[[nodiscard]] long mixed_negative_pivots(PC pc);
/// How often single precision was not enough, so far.
[[nodiscard]] long mixed_double_factors(PC pc);

}  // namespace voile::linear

// PC type "voile_inexact": solves symmetric systems of Newton's method only as exactly as the method needs, by conjugate
// gradients on an incomplete factor where that costs less than a factor.
//
// Conjugate gradients (-inexact_ksp_...) with voile_block_icc (-inexact_pc_...) stop when the residual in the norm of the
// inverse preconditioner, which stands for the energy of the error, has fallen to the tolerance in force: that of
// set_inexact_tolerance, or -pc_inexact_last_rtol for solutions so small that the iteration ends with them. What they do
// not reach within the number of iterations that costs as much as a factor is solved by a factor (voile_mixed,
// -inexact_factor_...), and so are the next matrices: 8 after the first failure, twice as many after each further one.
// That number is counted, not timed, so that a run repeats itself: -pc_inexact_break_even times the square root of the
// number of vertices, as nested dissection of a surface has it. Negative curvature in a Krylov space, which
// takes the place of negative pivots, is met with another matrix if the caller has one, else with a factor.
#pragma once

#include <petscksp.h>

#include <string>

namespace voile::linear {

inline constexpr const char* inexact_pc_type = "voile_inexact";

/// How the owner of the Newton iteration is asked; any may be null. Collective. Codes are those of PETSc.
struct InexactCallbacks {
  void* context = nullptr;
  /// The matrix has a direction of negative curvature: puts a positive one in its place, in the same object. `changed`
  /// is false if there is no other.
  PetscErrorCode (*make_positive)(void* context, PetscBool* changed) = nullptr;
  /// Whether x is so small that the iteration may end with it.
  PetscErrorCode (*is_last)(void* context, Vec x, PetscBool* last) = nullptr;
  /// What a user wants to know.
  PetscErrorCode (*say)(void* context, const std::string& text) = nullptr;
};

/// What has been done so far; the same on all ranks.
struct InexactCounts {
  long matrices = 0;            ///< all
  long factors = 0;             ///< of them by a factor, those included whose iterations failed
  long solutions = 0;           ///< by iteration
  long iterations = 0;          ///< of conjugate gradients, failed ones included
  long shifted = 0;             ///< incomplete factors with a shift
  long negative_curvature = 0;  ///< found by conjugate gradients
};

/// What decides about later matrices, for checkpoints.
struct InexactMemory {
  int factors_left = 0;  ///< matrices to be factored before iterations are tried again
  int wait = 0;          ///< how many they were when this began; 0: iterations have not failed since they last worked
};

/// Makes the type known to PETSc; again does nothing.
void register_inexact_pc();
void set_inexact_callbacks(PC pc, const InexactCallbacks& callbacks);
/// Whether the next matrix may be indefinite, so that one without an incomplete factor is a failure (as that of a factor
/// would be) to be met with another matrix. Not collective.
void expect_indefinite(PC pc, bool possible);
/// Relative tolerance of the next solutions; 0: as exact as can be (the state at the start).
void set_inexact_tolerance(PC pc, double relative);
/// Factors in double precision always, where round-off counts.
void set_inexact_double(PC pc);
[[nodiscard]] const InexactCounts& inexact_counts(PC pc);
[[nodiscard]] InexactMemory inexact_memory(PC pc);
void set_inexact_memory(PC pc, const InexactMemory& memory);
/// Of the last factor; -1 if the last matrix has none.
[[nodiscard]] long inexact_negative_pivots(PC pc);

}  // namespace voile::linear

#include "inertia.hpp"

#include "base/petsc.hpp"
#include "linear_solver.hpp"

namespace voile::linear {

namespace {

/// |A|/|K| that round-off of an assembly can leave.
constexpr double round_off = 1e-12;
/// MUMPS's own reserve of 20 % fails at random in parallel.
constexpr PetscInt workspace = 200;

}  // namespace

Inertia inertia_of(Mat tangent) {
  Inertia result;
  petsc::MatHandle symmetric, factor;
  double size = 0.0, skew = 0.0;
  VOILE_PETSC(MatTranspose(tangent, MAT_INITIAL_MATRIX, symmetric.out()));
  VOILE_PETSC(MatAXPY(symmetric, -1.0, tangent, SAME_NONZERO_PATTERN));
  VOILE_PETSC(MatNorm(symmetric, NORM_FROBENIUS, &skew));
  VOILE_PETSC(MatNorm(tangent, NORM_FROBENIUS, &size));
  result.conservative = 0.5 * skew <= round_off * size;
  // K^T - K is there: S = K + (K^T - K)/2.
  VOILE_PETSC(MatScale(symmetric, 0.5));
  VOILE_PETSC(MatAXPY(symmetric, 1.0, tangent, SAME_NONZERO_PATTERN));
  VOILE_PETSC(MatSetOption(symmetric, MAT_SYMMETRIC, PETSC_TRUE));
  VOILE_PETSC(MatGetFactor(symmetric, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factor.out()));
  VOILE_PETSC(MatMumpsSetIcntl(factor, mumps_workspace_percent, workspace));
  MatFactorInfo info;
  VOILE_PETSC(MatFactorInfoInitialize(&info));
  VOILE_PETSC(MatCholeskyFactorSymbolic(factor, symmetric, nullptr, &info));
  VOILE_PETSC(MatCholeskyFactorNumeric(factor, symmetric, &info));
  MatFactorError error = MAT_FACTOR_NOERROR;
  VOILE_PETSC(MatFactorGetError(factor, &error));
  if (error != MAT_FACTOR_NOERROR) return result;
  PetscInt count = 0;
  VOILE_PETSC(MatMumpsGetInfog(factor, mumps_negative_pivots, &count));
  result.negative = count;
  return result;
}

}  // namespace voile::linear

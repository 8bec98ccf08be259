// The eigenvector of a tangent nearest to singularity.
// Source: B. N. Parlett, The Symmetric Eigenvalue Problem (1998), chapter 4.
#pragma once

#include "linear_solver.hpp"

namespace voile::linear {

/// A vector that no symmetry of a problem makes blind, the same for any number of ranks, free components only,
/// <x, x> = 1 in the lumped mass. Collective.
[[nodiscard]] petsc::VecHandle start_mode(const system::Model& model);

/// Some inverse iterations K y = M x from and into `mode` with the tangent that `linear` factored last (M lumped mass).
/// Returns the eigenvalue nearest to zero [1/s^2], 0 if the solver fails. Collective.
[[nodiscard]] double inverse_iteration(const system::Model& model, LinearSolver& linear, Vec mode, int iterations);

}  // namespace voile::linear

// How many negative eigenvalues a tangent has that is not symmetric, as with follower loads; private to src/solve.
//
// Symbols   K tangent,  S = (K + K^T)/2 its symmetric part,  A = K - S
// S is factored (MUMPS, L D L^T): D has as many negative entries as S negative eigenvalues (Sylvester). Where A vanishes
// the loads have a potential (a pressure in a closed or held rim) and S is the tangent; otherwise a count of 0 still says
// that no small motion gains energy, and any other count nothing for certain. Source: V.V. Bolotin, Nonconservative
// Problems of the Theory of Elastic Stability, Pergamon, 1963.
#pragma once

#include <petscmat.h>

namespace voile::linear {

struct Inertia {
  long negative = -1;         ///< of S; -1: not known, the factorisation failed
  bool conservative = false;  ///< A vanishes but for round-off
};

/// Collective. `tangent` has a symmetric pattern.
[[nodiscard]] Inertia inertia_of(Mat tangent);

}  // namespace voile::linear

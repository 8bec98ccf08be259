// What an element kernel offers to assembly, and what it is given.
//
// A term is a set of elements with fixed stencils of local points. For element e it offers
//   size(), stencil(e)            number of elements; local point numbers
//   owned(e)                      true on the one rank that counts its energy
//   energy(e, c)                  value [J]
//   gradient(e, c, emit)          emit(a, force) for stencil positions a: derivative of the energy [N]
//   hessian(e, c, emit)           emit(a, b, block) for pairs of stencil positions, 3x3 [N/m]
//   blocks(e, emit)               emit(a, b) in exactly the order of hessian(): assembly maps it to matrix places once
// Terms know nothing of matrices, ranks or constraints; calls are inlined, nothing is allocated in an element loop.
#pragma once

#include <vector>

#include "base/types.hpp"

namespace voile::energy {

/// Which membrane stress enters the geometric stiffness.
enum class Tangent {
  exact,              ///< second derivative of the energy
  linearised_stress,  ///< C:(E(x_k) + B(x_k) dx) of the previous iterate x_k ("mixed integration point" tangent)
  positive,           ///< stress projected to its tensile part: never indefinite
  stress_alone  ///< of membranes the one at x_k with the stress at x: that of x and x_k differ by what stress stiffens
};

/// Current configuration of the local points.
struct Configuration {
  const Vec3* x = nullptr;         ///< current positions [m]
  const Vec3* u = nullptr;         ///< displacements from rest [m], free of the round-off of x - X
  const Vec3* previous = nullptr;  ///< positions x_k, for Tangent::linearised_stress and Tangent::stress_alone, or null
  Tangent tangent = Tangent::exact;
  const Vec3* previous_u = nullptr;  ///< displacements there, for Tangent::stress_alone
};

}  // namespace voile::energy

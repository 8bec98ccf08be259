// What a load that grows changes of the tangent: the stiffness of linear buckling.
//
// Symbols   a  equilibrium, x_f = dx/dlambda the response to the load there, u = a + mu x_f
//   K' = d/dmu of the tangent at u and lambda + mu, of which membranes have
//   sum over strains of N' : d2E/da2,   N' = C : (dE/da) x_f
// The change of their geometry is left out: to first order alone it couples stretching to bending wherever the sheet bends before it
// buckles, and gives modes below the buckling load that no sheet has.
// Source: O.C. Zienkiewicz & R.L. Taylor, The Finite Element Method, Vol. 2, 5th ed. (2000), chapter 11 (elastic stability).
#pragma once

#include "base/petsc.hpp"
#include "system/model.hpp"

namespace voile::solve {

/// By a central difference with displacements far below an edge length, and natural strains far below 1; `larger`: times the usual
/// step. The tangent assembled last is then the exact one at a. Collective.
[[nodiscard]] petsc::MatHandle load_stiffness(system::Model& model, Vec a, Vec load_solution, double larger = 1.0);

}  // namespace voile::solve

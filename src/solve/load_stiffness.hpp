// What a load that grows changes of the tangent: the stiffness of linear buckling.
//
// Symbols   a  equilibrium, x_f = dx/dlambda the response to the load there, u = a + mu x_f
//   K' = d/dmu of the tangent at u and lambda + mu, of which membranes have
//   sum over strains of N' : d2E/da2,   N' = C : (dE/da) x_f
// The change of their geometry is left out: to first order alone it couples stretching to bending wherever the sheet bends before it
// buckles, and gives modes below the buckling load that no sheet has.
// Source: O.C. Zienkiewicz & R.L. Taylor, The Finite Element Method, Vol. 2, 5th ed. (2000), chapter 11 (elastic stability).
#pragma once

#include <vector>

#include "eigen.hpp"

namespace voile::solve {

/// An equilibrium and the response to the load there.
struct LoadResponse {
  system::Model& model;
  Vec a, solution;
};

/// K', by a central difference with displacements far below an edge length, and natural strains far below 1. The tangent assembled
/// last is then the exact one at a. Collective.
[[nodiscard]] petsc::MatHandle load_stiffness(const LoadResponse& of);

/// Leaves out modes whose eigenvalue is what round-off leaves of stresses that are not there: with a larger step it is another.
/// `stiffness`: K'. Collective.
void drop_round_off(const LoadResponse& of, Mat stiffness, std::vector<Mode>& modes);

/// |v| / |u| mu / (lambda + mu), where u is the response to `mu` more of the load by the tangent, and v its first correction by
/// Newton's method. The tangent assembled last is then the exact one at a. Collective.
[[nodiscard]] double nonlinearity(const LoadResponse& of, linear::LinearSolver& linear, double mu);

}  // namespace voile::solve

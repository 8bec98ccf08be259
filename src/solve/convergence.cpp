#include "voile/solve/convergence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voile::solve {

namespace {

/// Positions are known to eps |X|, forces per vertex to eps |X| times the stiffness of a cell against stretching, and
/// against bending within it.
double round_off_of(const system::Model& model) {
  const double cell = model.discretisation().mean_area();
  double stiffness = 0.0, distance = model.dofs().mesh().extent();
  for (const energy::Material& m : model.discretisation().materials())
    stiffness = std::max(stiffness, m.membrane.norm() + m.bending.norm() / cell);
  for (const Vec3& x : model.dofs().mesh().positions()) distance = std::max(distance, x.norm());
  return std::numeric_limits<double>::epsilon() * stiffness * distance *
         std::sqrt(static_cast<double>(model.dofs().unknowns()));
}

}  // namespace

ConvergenceTest::ConvergenceTest(const system::Model& model)
    : round_off_(round_off_of(model)),
      wild_(20.0 * model.dofs().mesh().extent() * std::sqrt(static_cast<double>(model.dofs().unknowns()))) {}

void ConvergenceTest::read(SNES snes) {
  PetscInt iterations = 0;
  VOILE_PETSC(SNESGetTolerances(snes, &atol_, &rtol_, &stol_, &iterations, nullptr));
  max_iterations_ = static_cast<int>(iterations);
}

bool ConvergenceTest::nothing_to_do(double residual, double force) const {
  return residual <= std::max(atol_, 1e-3 * rtol_ * force);
}

SNESConvergedReason ConvergenceTest::judge(const Progress& p) const {
  if (p.residual <= std::max(atol_, rtol_ * p.force) && p.increment <= stol_ * p.step)
    return SNES_CONVERGED_FNORM_RELATIVE;
  if (p.increment <= 1e-3 * stol_ * p.step && std::abs(p.work) <= 1e-3 * rtol_ * p.force * p.step)
    return SNES_CONVERGED_SNORM_RELATIVE;
  // Round-off that another iteration cannot lower: forces far below the sheet's stiffness, or a start in equilibrium.
  if (p.residual <= round_off_ && p.residual >= 0.1 * p.residual_before) return SNES_CONVERGED_SNORM_RELATIVE;
  return SNES_CONVERGED_ITERATING;
}

}  // namespace voile::solve

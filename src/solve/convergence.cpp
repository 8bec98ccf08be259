#include "convergence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "voile/errors.hpp"

namespace voile::solve {

namespace {

constexpr double loosest = 1e-3;  ///< residual of an equilibrium, relative to the forces

double farthest(const system::Model& model) {
  double distance = model.dofs().mesh().extent();
  for (const Vec3& x : model.dofs().mesh().positions()) distance = std::max(distance, x.norm());
  return distance;
}

/// What yarns add to the membrane stiffness at most, friction that sticks included [N/m].
double added_stiffness(const energy::YarnLaw& law) {
  double most = 0.0;
  for (const auto& knots : law.knots) {
    double tangent = 0.0, bend = 0.0, at = 0.0;
    for (const energy::YarnLaw::Knot& k : knots) {
      most = std::max(most, tangent += bend * (k.strain - at));
      bend += k.bend;
      at = k.strain;
    }
  }
  return most + law.stiffness;
}

/// Of a cell against stretching, and against bending within it [N/m].
double cell_stiffness(const system::Model& model) {
  const double cell = model.discretisation().mean_area();
  double stiffness = 0.0;
  for (const energy::Material& m : model.discretisation().materials())
    stiffness = std::max(stiffness, m.membrane.norm() + added_stiffness(m.yarns) + m.bending.norm() / cell);
  return stiffness;
}

}  // namespace

std::string part_of_forces(double residual) {
  return residual > loosest ? "of round-off" : fmt::format("{:.1e} of the forces", residual);
}

ConvergenceTest::ConvergenceTest(const system::Model& model)
    : distance_(farthest(model)),
      resolution_(std::numeric_limits<double>::epsilon() * std::sqrt(static_cast<double>(model.dofs().unknowns()))),
      stiffness_(cell_stiffness(model)),
      wild_(20.0 * model.dofs().mesh().extent() * std::sqrt(static_cast<double>(model.dofs().unknowns()))) {
  set_round_off(distance_);
}

void ConvergenceTest::set_round_off(double distance) {
  position_round_off_ = resolution_ * distance;
  round_off_ = position_round_off_ * stiffness_;
}

void ConvergenceTest::see(Vec a) {
  double moved = 0.0;
  VOILE_PETSC(VecNorm(a, NORM_INFINITY, &moved));
  set_round_off(distance_ + (std::isfinite(moved) && moved > distance_ ? moved : 0.0));
}

void ConvergenceTest::read(SNES snes) {
  PetscInt iterations = 0;
  VOILE_PETSC(SNESGetTolerances(snes, &atol_, &rtol_, &stol_, &iterations, nullptr));
  max_iterations_ = static_cast<int>(iterations);
  if (rtol_ > loosest)
    throw UserError(fmt::format(
        "-snes_rtol {:g}: a state that is off by more than {:g} of the forces is no equilibrium; give a smaller number",
        rtol_, loosest));
}

double ConvergenceTest::allowed(double force) const {
  return std::max(rtol_ * force, std::min(atol_, std::max(loosest * force, round_off_)));
}

bool ConvergenceTest::nothing_to_do(double residual, double force) const {
  return residual <= std::max(1e-3 * rtol_ * force, std::min(atol_, allowed(force)));
}

SNESConvergedReason ConvergenceTest::judge(const Progress& p) const {
  if (!p.is_newton) {
    if (p.residual <= allowed(p.force)) return SNES_CONVERGED_FNORM_RELATIVE;
    return p.residual <= round_off_ && p.residual >= 0.1 * p.residual_before ? SNES_CONVERGED_FNORM_ABS
                                                                             : SNES_CONVERGED_ITERATING;
  }
  if (p.residual <= allowed(p.force) && p.increment <= stol_ * p.step) return SNES_CONVERGED_FNORM_RELATIVE;
  if (p.increment <= 1e-3 * stol_ * p.step && std::abs(p.work) <= 1e-3 * rtol_ * p.force * p.step)
    return SNES_CONVERGED_SNORM_RELATIVE;
  // Round-off that another iteration cannot lower: forces far below the sheet's stiffness, or a start in equilibrium.
  if (p.residual <= round_off_ && p.residual >= 0.1 * p.residual_before) return SNES_CONVERGED_SNORM_RELATIVE;
  if (p.increment <= position_round_off_ && p.residual >= 0.1 * p.residual_before) return SNES_CONVERGED_SNORM_RELATIVE;
  return SNES_CONVERGED_ITERATING;
}

bool ConvergenceTest::is_balanced(double residual, double force) const {
  return residual <= std::max(allowed(force), round_off_);
}

}  // namespace voile::solve

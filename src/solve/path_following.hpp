// Equilibrium paths with the load factor as an unknown: displacement control and arc length.
//
// Symbols   r(a, lambda)  residual;  K = dr/da exact tangent;  f = -dr/dlambda
//           Da, Dlambda   increment since the last accepted state;  da, dlambda  correction in one iteration
//           W             lumped mass per unknown;  <x, y> = x.W y,  |x|^2 = <x, x>;  L  length of the step
//           c             probe, a linear function of the displacements;  q  its prescribed value
// Iteration   K x_r = r,  K x_f = f   (one factorisation, two back-substitutions),   da = -x_r + dlambda x_f
//   arc length     <Da, Da> = L^2, linearised:  dlambda = ((L^2 - <Da, Da>)/2 + <Da, x_r>) / <Da, x_f>
//   displacement   c.(a + da) = q:               dlambda = (q - c.a + c.x_r) / (c.x_f)
// (cylindrical arc length, consistently linearised: Schweizerhof & Wriggers, Comput. Methods Appl. Mech. Engng 59
// (1986) 261-279; Crisfield, Non-linear Finite Element Analysis of Solids and Structures 1 (1991), chapter 9.)
// Predictor   Da = +-L x_f/|x_f|, the sign such that <Da, previous Da> > 0.
// Step length grows with sqrt(wanted/needed iterations), at most by 2, and is halved when a step fails.
// On another mesh   every correction is orthogonal to the path of its load factor, <da, x_f> = 0:
//                        dlambda = <x_r, x_f> / <x_f, x_f>      (normal flow; Ragon, Gurdal & Watson, Int. J. Solids
//                        Structures 39 (2002) 689-698), until the state is in equilibrium.
// The length of a step, the unit that it is measured in, the direction, and what is known of critical points continue from
// system::State, so that a path is the same through remeshings and restarts.
// Critical points: between two states a limit point changes the sign of dlambda along the path, a bifurcation changes
// the number of negative pivots without it. The eigenvalue of K (in W) nearest to zero is followed by inverse
// iteration. Theory: docs/theory/path-following.md (2).
#pragma once

#include <memory>

#include "load_path.hpp"

namespace voile::solve {

class PathFollower : public Stepper {
 public:
  /// `probe` is c in unknowns of the model, null if nothing is controlled or watched; copied. The model must outlive it.
  /// Collective.
  PathFollower(system::Model& model, StaticOptions options, Vec probe);
  ~PathFollower() override;

  /// A state that is not in equilibrium is brought to one at its load factor first. Throws UserError if the tangent is
  /// singular there or the load does nothing.
  [[nodiscard]] StepResult begin(system::State& state) override;
  [[nodiscard]] StepResult advance(system::State& state) override;
  [[nodiscard]] bool finished(const system::State& state) const override;
  /// Instead of begin(): brings a state of another mesh to the path of this one and leaves it near the place where it was,
  /// which load factor and displacements share: limit loads of this mesh may be lower than the load in force. With
  /// displacement control, and at the end of the path, the probe keeps `probed_before` [m]. The state's load factor
  /// changes. Collective.
  [[nodiscard]] NewtonResult regain(system::State& state, double probed_before);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voile::solve

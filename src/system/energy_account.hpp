// Keeps the balance of a motion's energy, step by step (energy_balance.hpp).
#pragma once

#include "base/petsc.hpp"
#include "dynamics.hpp"
#include "energy_balance.hpp"

namespace voile::system {

class EnergyAccount {
 public:
  /// `dynamics` must outlive it; prescribed motions hardly change over `moment` [s]. Collective.
  explicit EnergyAccount(Dynamics& dynamics, double moment = 1e-6);

  /// Goes on from state (u, v) at the time in force with what came before: where energies are others now than in the last
  /// state, a new mesh or supports that have released made them so. Collective.
  /// `other_case`: a restart, whose case may differ; then the motion has begun with that energy.
  /// `a`: accelerations, null at the start of a motion.
  void begin(Vec u, Vec v, Vec a, const EnergyBalance& before, bool other_case = false);
  /// The forces of a step from u_0 to u_1, at its stage (u, v, a) and the stage's time, which is in force. Collective.
  void take_forces(Vec u_0, Vec u_1, Vec u, Vec v, Vec a);
  /// The step from time `t_0` has ended at `t_1` with (u_1, v_1); leaves t_1 in force. Collective. [s]
  void end_step(Vec u_1, Vec v_1, double t_0, double t_1);

  [[nodiscard]] const EnergyBalance& balance() const { return balance_; }

  /// Forces at the end of the last step are others than in it: a gas has leaked. Collective.
  void renew(Vec u, Vec v, Vec a);

 private:
  struct Levels {
    double kinetic = 0.0, internal = 0.0, contact = 0.0;
    double held = 0.0;  ///< of the kinetic energy, what supports give to what they hold
    [[nodiscard]] double sum() const { return kinetic + internal + contact; }
  };
  [[nodiscard]] Levels levels(Vec u, Vec v);
  /// Work of what drives places and lengths of springs, clamps and seams in the step.
  [[nodiscard]] double driven(Vec u_1, double t_0, double t_1, double internal_now);

  Dynamics& dynamics_;
  double moment_;
  EnergyBalance balance_;
  Levels before_;
  Dynamics::Work work_;
  double friction_ = 0.0, obstacles_ = 0.0;  ///< of the step: taken by friction; work of obstacles against barriers
  petsc::VecHandle start_, displacement_;
  /// Loads and reactions at the last stage, and its time; their works in the step that follows. The work of a step is that of the
  /// forces in its middle, between those of two stages: what is at its end would add half of what changes over it.
  struct Stage {
    petsc::VecHandle loads, reactions, external;  ///< `external`: of the loads, those from outside
    bool forced = false;                          ///< whether there are any
    double time = 0.0, load_work = 0.0, reaction_work = 0.0;
  };
  void take_stage(Vec u, Vec v, Vec a, Vec displacement);
  Stage last_, now_;
};

}  // namespace voile::system

// Analyses of one step: small deflections, and an equilibrium under the loads in force.
#pragma once

#include "stepper.hpp"

namespace voile::solve {

/// Small deflections: one linear solution from the state, under the loads at a load factor.
class LinearStep : public Stepper {
 public:
  /// The model must outlive it.
  LinearStep(system::Model& model, double load_factor) : model_(model), load_factor_(load_factor) {}

  [[nodiscard]] StepResult begin(system::State& state) override;
  [[nodiscard]] StepResult advance(system::State& state) override;
  [[nodiscard]] bool finished(const system::State& state) const override;

 private:
  system::Model& model_;
  double load_factor_;
  bool done_ = false;
};

/// The equilibrium near a state at its load factor, without a step: what modes are found about. A state that is not in
/// equilibrium is brought to one.
class Equilibrium : public Stepper {
 public:
  /// The model must outlive it. `search`: loads that the state does not know act on it, constant ones on the unloaded
  /// state.
  Equilibrium(system::Model& model, bool search) : model_(model), search_(search) {}

  [[nodiscard]] StepResult begin(system::State& state) override;
  [[nodiscard]] StepResult advance(system::State& state) override;
  [[nodiscard]] bool finished(const system::State&) const override { return true; }

 private:
  system::Model& model_;
  bool search_;
};

}  // namespace voile::solve

// Quasi-static load path: the load factor grows in steps that adapt to Newton's effort.
//
// A step that converges in few iterations lets the next one grow by up to 2; a step that fails is halved. If the half
// fails too, pseudo-transient continuation is tried there once (if allowed), and stepping continues from what it finds.
#pragma once

#include <optional>

#include "static_options.hpp"
#include "stepper.hpp"

namespace voile::solve {

/// Options -path_... of PETSc, which win over the case file. Collective.
void read_path_options(MPI_Comm comm, StaticOptions& options);

/// Load control.
class LoadPath : public Stepper {
 public:
  /// Obstacles are where they are at the load factor, if `obstacles_move` says so; `restarted`: with a state that may be of
  /// another case. The model must outlive it.
  LoadPath(system::Model& model, StaticOptions options, bool obstacles_move = false, bool restarted = false)
      : model_(model), options_(std::move(options)), obstacles_move_(obstacles_move), restarted_(restarted) {}

  /// A state that is not in equilibrium is brought to one at its load factor first.
  [[nodiscard]] StepResult begin(system::State& state) override;
  [[nodiscard]] StepResult advance(system::State& state) override;
  [[nodiscard]] bool finished(const system::State& state) const override;

 private:
  [[nodiscard]] double next_target(double from, double step) const;
  [[nodiscard]] StepResult attempt(system::State& state);
  /// From the accepted state to equilibrium at load factor `to`, friction included. Overwrites state.u.
  [[nodiscard]] NewtonResult settle(system::State& state, double to, bool by_continuation);
  void set_load_factor(double factor);
  /// The state goes on as the step before did. Overwrites state.u.
  void predict(system::State& state, double to) const;
  /// What a state that is gone on with has of friction, from the step that led to it.
  void recall_friction(const system::State& state);
  void halve(system::State& state, StepResult& r, double target, double taken);

  system::Model& model_;
  StaticOptions options_;
  bool obstacles_move_, restarted_;
  std::optional<Newton> newton_;
  petsc::VecHandle accepted_;
  double step_ = 0.0;
  int halvings_ = 0;
};

/// Whether a path that ends at `wanted` is there.
[[nodiscard]] bool at_load_factor(double wanted, double factor);
/// Brings a state to equilibrium at its load factor by pseudo-transient continuation, unless it is in one; the model's
/// load factor becomes that of the state. Collective.
[[nodiscard]] StepResult find_equilibrium(system::Model& model, system::State& state);
/// The same from a state near a stable equilibrium, as after a remeshing, by Newton's method with full steps; where that
/// fails or ends in an unstable state, the state is as before. Collective.
[[nodiscard]] StepResult regain_equilibrium(system::Model& model, system::State& state);
/// Whether a state that was an equilibrium is one of this model, too: another case may act on it. Collective.
[[nodiscard]] bool is_balanced(system::Model& model, Vec u);

}  // namespace voile::solve

// The inner parts of TimeIntegration; private to src/solve.
#pragma once

#include <petscts.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "solver_choice.hpp"
#include "system/energy_account.hpp"
#include "time_integration.hpp"

namespace voile::solve {

using TsHandle = petsc::Handle<TS, TSDestroy>;

struct TimeIntegration::Impl {
  static constexpr int first_patience = 2;
  system::Dynamics& dynamics;
  system::Model& model;
  TimeOptions options;
  const Remark& remark;
  bool inexact;
  TsHandle ts;
  linear::LinearSolver linear;
  std::optional<system::EnergyAccount> account;
  ConvergenceTest test;
  SolverChoice choice;
  petsc::VecHandle trial, start, product;
  bool own_search = true;         ///< the line search is ours
  double full_increment = 0.0;    ///< norm of the increment before a line search of PETSc shortens it [m]
  bool judged_converged = false;  ///< by `judge`, at the last iterate
  double residual_before = 0.0, work = 0.0, rms = -1.0, length = 1.0, residual = 0.0;
  bool cut = false;  ///< contact did not let the last iteration go the whole way
  int cuts = 0;      ///< iterations of this step for which that holds
  double shortest = 1.0;
  std::string obstruction;
  double last_taken = 0.0;  ///< size of the last accepted step [s]
  double first_step = 0.0;  ///< size of the first step, before the end cuts it [s]
  double wanted = 0.0;      ///< size of the next step, which PETSc may cut to meet the end [s]
  IterativeEffort spent_iterative;
  /// The next tangent is to be the exact one: no iteration follows that would mend what a positive one leaves.
  bool exact_tangent = false;
  int positive_left = 0, spent_factorisations = 0, spent_rejections = 0;
  /// Of this step: the iteration gains a constant factor only, so that the exact tangent is worth another look; iterations
  /// to go before the next one, and how many after it if it is indefinite still; it was not. Rate of the residual last.
  struct {
    bool slow = false, exact = false;
    int left = 0, patience = first_patience;
    double rate = 0.0;
  } again;
  bool explicit_method = false;
  double held_at = std::numeric_limits<double>::quiet_NaN();  ///< time of the following [s]
  petsc::VecHandle held_v, held_a;  ///< velocities and accelerations of what is held, at the end of the step; else zero
  /// Of central differences: bounds of the step that the case gives [s], what is remembered of the largest frequency, its mode.
  struct {
    double most = 0.0, least = 0.0;
    double damping = 0.0;  ///< largest rate [1/s]
    system::StabilityMemory memory;
    petsc::VecHandle mode;
  } stability;
  system::StepStart coming;     ///< of the explicit method: where the next step starts
  system::StepStart under_way;  ///< the step, if forces depend on it
  /// Of the tangent in force: its state, owned by the TS, what stands before its velocity and acceleration, its kind.
  struct {
    Vec u = nullptr;
    double s_v = 0.0, s_a = 0.0;
    bool positive = false;
  } tangent;

  Impl(system::Dynamics& d, TimeOptions o, const Remark& r, bool by_iteration)
      : dynamics(d), model(d.model()), options(o), remark(r), inexact(by_iteration), linear(model), test(model) {
    for (petsc::VecHandle* v : {&trial, &start, &product, &held_v, &held_a}) *v = model.dofs().create_vector();
    if (options.max_step == 0.0) options.max_step = options.step;
    if (options.min_step == 0.0) options.min_step = 1e-3 * options.step;
  }

  void create(const system::State& from);
  void choose_method(const system::State& from);
  void create_snes();
  void read_solver_choice();
  void set_explicit_step(const system::State& from);
  void limit_explicit_step(double limit);
  /// After an accepted step.
  void keep_stability(system::State& state);
  [[nodiscard]] bool follow_stability(const system::State& state);
  void prepare_inexact(const system::SolverMemory& memory);
  [[nodiscard]] system::SolverMemory solver_memory() const;
  /// Assembles the tangent and prepares its solution; false if that failed.
  [[nodiscard]] bool assemble(energy::Tangent kind);
  /// Whether the next tangent is to be the positive one.
  [[nodiscard]] bool stay_positive();
  void note_indefinite();
  void note_rate(double rate);
  void set_tolerance(PetscInt it, double norm, double before);
  [[nodiscard]] bool is_last(Vec increment);
  /// Root mean square of an increment that ends a step of size h [m].
  [[nodiscard]] double last_increment(double h) const;
  [[nodiscard]] double objective(Vec x);
  /// Of the vertices' displacements in y, over the mass [m].
  [[nodiscard]] double root_mean_square(Vec y);
  [[nodiscard]] bool clear_predictor(double t0, Vec x0, double t1, Vec x1);
  void search(SNESLineSearch line_search);
  /// Where the last solve left the largest residuals, in words. Collective.
  [[nodiscard]] std::string place_of_failure();
  void see_increment(SNESLineSearch search, Vec x, Vec y);
  /// The verdict on where a SNES has stopped for reasons of its own.
  void confirm(SNES snes, Vec x1);
  [[nodiscard]] SNESConvergedReason judge_iterate(SNES snes, PetscInt it, double increment, double norm);
  [[nodiscard]] SNESConvergedReason judge(SNES snes, PetscInt it, double increment, double norm);
  [[nodiscard]] double by_motions(double t, double h) const;
  [[nodiscard]] double next_step(double h, PetscBool* accept, PetscReal* error);
  [[nodiscard]] double until() const { return std::min(options.end_time, options.until); }
  void accept(system::State& state, StepResult& r);
  void fail(system::State& state, StepResult& r, TSConvergedReason reason);
  void note_effort(StepResult& r);
  void prepare_first_step(const system::State& state);
  void meet_end(double time, double step);
  void view_at_end(const system::State& state);
  [[nodiscard]] bool ended() const;
  /// The sum of many steps may miss the end by its round-off.
  [[nodiscard]] bool is_end(double time) const {
    return std::abs(time - until()) <= 1e-12 * std::max(1.0, std::abs(until()));
  }

  static PetscErrorCode function(TS, PetscReal t, Vec u, Vec v, Vec a, Vec f, void* self);
  static PetscErrorCode jacobian(TS, PetscReal t, Vec u, Vec v, Vec a, PetscReal s_v, PetscReal s_a, Mat, Mat,
                                 void* self);
  /// Whether forces at the end of a step depend on its start.
  [[nodiscard]] bool remembers_start() const;
  /// Of what is held, where they are not null.
  void take_rates(Vec v, Vec a);
  void set_start(system::StepStart& start, Vec x, Vec v, double time, double size);

  static PetscErrorCode start_step(void* self, Vec x, Vec v, PetscReal step);
  static PetscErrorCode exactly(void* self);
  static PetscErrorCode enforce(void* self, PetscReal t, Vec stage);
  static PetscErrorCode prescribe(void* self, Vec v, Vec a);
  static PetscErrorCode clear(void* self, PetscReal t0, Vec x0, PetscReal t1, Vec x1, PetscBool* possible);
  static PetscErrorCode energy(void* self, Vec x1, PetscReal* value);
  static PetscErrorCode accepted(void* self, Vec x0, Vec x1, Vec v1);
  static PetscErrorCode accelerate(void* self, PetscReal t, Vec x, Vec v, Vec a);
  static PetscErrorCode make_positive(void* self, PetscBool* changed);
  static PetscErrorCode line_search(SNESLineSearch ls, void* self);
  static PetscErrorCode before_line_search(SNESLineSearch ls, Vec x, Vec y, PetscBool* changed, void* self);
  static PetscErrorCode after_line_search(SNESLineSearch ls, Vec x, Vec y, Vec next, PetscBool* y_changed,
                                          PetscBool* next_changed, void* self);
  static PetscErrorCode after_linear_solve(KSP, Vec rhs, Vec x, void* self);
  static PetscErrorCode solved(void* self, Vec x1);
  static PetscErrorCode converged(SNES, PetscInt it, PetscReal, PetscReal snorm, PetscReal fnorm,
                                  SNESConvergedReason* reason, void* self);
  static PetscErrorCode choose(TSAdapt adapt, TS ts, PetscReal h, PetscInt* scheme, PetscReal* next, PetscBool* accept,
                               PetscReal* error, PetscReal* absolute, PetscReal* relative);
};

}  // namespace voile::solve

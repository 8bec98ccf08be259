// The inner parts of Newton; private to src/solve.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>

#include "newton.hpp"
#include "solver_choice.hpp"

namespace voile::solve {

/// Forces below this fraction of the largest of a search vanish: a sheet that no load holds comes to rest without any.
inline constexpr double vanishing_force = 1e-3;
/// And forces that are so many times what round-off leaves: a sheet without load that an earlier stage has left bent by
/// micrometres comes to rest too.
inline constexpr double rest_force = 1e8;

struct Newton::Impl {
  system::Model& model;
  petsc::SnesHandle snes;
  linear::LinearSolver linear;
  ConvergenceTest test;
  SolverChoice choice;
  petsc::VecHandle residual, start, previous, increment, trial;
  bool has_previous = false;
  double allowed = 1.0;  ///< fraction of the last increment that contact let pass
  double step_norm = 0.0, last_work = 0.0, last_residual = 0.0;
  double full_increment = 0.0;    ///< norm of the increment before a line search shortens it [m]
  bool judged_converged = false;  ///< by `judge`, at the last iterate
  double largest_force = 0.0;     ///< largest scale of forces in this search [N]
  std::function<void(int, double)> progress;

  explicit Impl(system::Model& m) : model(m), linear(m), test(m) {
    for (petsc::VecHandle* v : {&residual, &start, &previous, &increment, &trial}) *v = m.dofs().create_vector();
  }

  void create();
  [[nodiscard]] NewtonResult solve_once(Vec a);
  /// |r|/f in a search, with f no less than what counts as vanishing.
  [[nodiscard]] double relative(double norm) {
    largest_force = std::max(largest_force, model.force_scale());
    const double force =
        std::max({model.force_scale(), vanishing_force * largest_force, rest_force * test.round_off()});
    return force > 0.0 ? norm / force : norm;
  }
  /// Shift at which the residual moves the fastest vertex by about one cell.
  [[nodiscard]] double first_shift();
  /// Tangent with inertia-like shift: the exact one, or with membrane and contact made positive.
  void assemble_shifted(Vec a, bool exact, double shift);
  /// Energy of a, from which those of later states are counted.
  [[nodiscard]] double energy_at(Vec a) {
    model.potential().count_from(a);
    return model.energy(a);
  }
  [[nodiscard]] double backtrack(Vec a, double longest, double energy, double slope);
  /// Moves a against the increment, as far as contact allows and the energy falls: the fraction taken (0: nowhere), and the
  /// share that contact allowed.
  [[nodiscard]] std::pair<double, double> advance(Vec a, double energy);
  [[nodiscard]] SNESConvergedReason judge(PetscInt iteration, double increment_norm, double residual_norm);
  [[nodiscard]] SNESConvergedReason judge_iterate(PetscInt iteration, double increment_norm, double residual_norm);
  /// The verdict on where a SNES has stopped for reasons of its own.
  void confirm(Vec a, NewtonResult& result);

  static PetscErrorCode form_function(SNES, Vec a, Vec r, void* self);
  static PetscErrorCode form_jacobian(SNES, Vec a, Mat, Mat, void* self);
  static PetscErrorCode converged(SNES, PetscInt it, PetscReal xnorm, PetscReal snorm, PetscReal fnorm,
                                  SNESConvergedReason* reason, void* self);
  static PetscErrorCode before_line_search(SNESLineSearch, Vec a, Vec y, PetscBool* changed, void* self);
  static PetscErrorCode after_line_search(SNESLineSearch, Vec a, Vec y, Vec next, PetscBool* y_changed,
                                          PetscBool* next_changed, void* self);
  static PetscErrorCode before_linear_solve(KSP, Vec rhs, Vec x, void* self);
  static PetscErrorCode after_linear_solve(KSP, Vec rhs, Vec x, void* self);
};

}  // namespace voile::solve

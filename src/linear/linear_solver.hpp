// Linear systems K x = b with the tangent of a model, through PETSc's KSP.
//
// Defaults, set before the user's options: -ksp_type preonly -pc_type cholesky (lu with follower loads)
// -pc_factor_mat_solver_type mumps -mat_mumps_icntl_14 100; from 10 000 vertices on, if K is symmetric and no option tunes
// that factor, -pc_type voile_mixed (mixed_pc.hpp), which takes half the memory; or, in motion, where systems are many and inertia makes K
// well conditioned, if K is symmetric, -pc_type voile_inexact (inexact_pc.hpp). MUMPS's lack of workspace
// is answered with twice as much, several times. Negative pivots of the symmetric factor count the negative eigenvalues
// of K (Sylvester's law of inertia).
// What gases add to K is of low rank and kept apart: K has to be factored then, as by default (low_rank_solution.hpp).
#pragma once

#include <memory>
#include <string>

#include "system/model.hpp"

namespace voile::linear {

/// Throws UserError if INFOG(1) of MUMPS says that memory, or room for its files, was lacking; `size` is INFOG(2). Both are the same on all
/// ranks.
void check_mumps_room(int error, int size);

class LowRankSolution;

/// Part of a right-hand side that a solution may leave which no iteration mends: far above round-off in the thinnest sheets.
inline constexpr double well_solved = 1e-3;

/// How many real eigenvalues of a tangent are negative; -1: not known.
struct NegativeEigenvalues {
  long certain = -1;  ///< where loads have no potential 0, or odd: one is at least
  long likely = -1;   ///< where what they lack of one is small
};

class LinearSolver {
 public:
  /// The model must outlive the solver. Call `set_defaults`, the KSP's options, then `prepare`.
  explicit LinearSolver(system::Model& model);
  ~LinearSolver();

  /// Of statics, of motions that are to find a place of rest, and of motions.
  enum class Method { direct, mixed, inexact };
  /// Takes the KSP (not owned) and gives it the defaults. Collective.
  void set_defaults(KSP ksp, Method method = Method::direct);
  /// Sees what the user's options chose. Collective.
  void prepare();

  /// Solves with the model's last tangent; factors it first if it is new. False if that failed, see `failure`.
  /// Collective.
  [[nodiscard]] bool solve(Vec rhs, Vec x);
  /// The same, and false where more than that part of the right-hand side is left, whatever the options say. Collective.
  [[nodiscard]] bool solve_to(double most_left, Vec rhs, Vec x);
  /// Factors the model's last tangent now, so that its negative pivots are known before a solution. Collective.
  [[nodiscard]] bool factorise();
  /// After a failed solve: makes the factor usable again. True if trying again with more workspace may help.
  /// Collective.
  [[nodiscard]] bool repair(int attempt);
  /// Adds to x what gases change, and measures how well K x = b was solved, unless the solver is one of ours, which proves
  /// it. After each solution that did not come from `solve`. Collective.
  void complete_solution(Vec rhs, Vec x);
  /// False where the last solution left more than a hundredth of its right-hand side: such an increment does not tell how
  /// far the equilibrium is.
  [[nodiscard]] bool is_solved() const { return solved_; }
  /// The factor may be of an earlier tangent (-snes_lag_preconditioner): solutions are measured.
  void expect_stale_factor() { trusted_ = false; }
  /// Tells the solver that the tangent was assembled anew: for the count of factorisations, and so that a factor of
  /// another pattern goes. Collective.
  void tangent_changed();

  /// Complete factors; without voile_inexact, tangents that were to be factored.
  [[nodiscard]] int factorisations() const;
  /// The PC if it is of type voile_inexact, otherwise null.
  [[nodiscard]] PC inexact() const;
  /// Of the last factorisation; -1 if the solver does not tell. Collective.
  [[nodiscard]] long negative_pivots() const;
  /// Negative eigenvalues of the model's last tangent, by a factor of its own where the solver does not tell: of its symmetric
  /// part where follower loads make it unsymmetric. Where those have no potential and that count is not 0, the sign of the
  /// determinant tells whether it is odd. Collective.
  [[nodiscard]] NegativeEigenvalues count_negative();
  [[nodiscard]] long negative_eigenvalues() { return count_negative().certain; }
  /// Those of them that round-off cannot make: they stay where each entry of the diagonal grows by some of its round-off. A motion
  /// that nothing resists, as of an unloaded sheet about its hinge, has the eigenvalue 0, and any sign. Collective.
  [[nodiscard]] long certain_negative_eigenvalues();
  /// What failed last, for the log; emptied by the call.
  [[nodiscard]] std::string take_failure();

 private:
  [[nodiscard]] Mat factor() const;
  void renew_factor(PetscInt workspace_percent);
  void check_solution(Vec rhs, Vec x);
  [[nodiscard]] double part_left(Vec rhs, Vec x) const;
  /// Negative pivots of what is factored, without what gases add.
  [[nodiscard]] long sparse_pivots() const;
  /// Sign of the determinant of the last LU; 0: not known.
  [[nodiscard]] int determinant_sign() const;
  [[nodiscard]] const system::LowRankChange& change() const { return model_.tangent().change(); }

  system::Model& model_;
  KSP ksp_ = nullptr;
  bool mumps_ = false, cholesky_ = false, mixed_ = false, inexact_ = false, statics_ = false, trusted_ = false,
       solved_ = true;
  int factorisations_ = 0, pattern_version_ = 0;
  bool completed_ = false;  ///< the last solution, by who was called after it
  std::unique_ptr<LowRankSolution> low_rank_;
  std::string failure_;
};

/// MUMPS's answers that Voile asks for, by number of the arrays ICNTL and INFOG in MUMPS's manual.
inline constexpr int mumps_workspace_percent = 14, mumps_error = 1, mumps_negative_pivots = 12,
                     mumps_finds_determinant = 33, mumps_determinant = 12;  // the last of RINFOG

}  // namespace voile::linear

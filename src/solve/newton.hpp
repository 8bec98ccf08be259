// Newton's method on a model at a fixed load factor, through PETSc's SNES.
//
// Symbols   r residual, K tangent, dx increment, f scale of forces (Model::force_scale), M lumped mass
// Stepping:      K(S*) dx = -r with S* the linearised stress of the previous iterate (tangent of "mixed
//                integration points", Magisano, Leonetti & Garcea, Comput. Methods Appl. Mech. Engng 313 (2017)
//                986-1005) and full steps: few iterations, independent of the mesh, but the load step must be small.
// Continuation:  (K+ + s M) dx = -r, K+ with the tensile part of the stress, backtracking on the energy, s halved after
//                each full step: pseudo-transient continuation, which finds equilibria across snaps. Close to one the
//                exact tangent, with s raised while it is indefinite; Newton steps finish it.
// Convergence is judged by convergence.hpp, linear systems are solved by linear_solver.hpp.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "convergence.hpp"
#include "linear/linear_solver.hpp"
#include "system/model.hpp"

namespace voile::solve {

/// What came of a solve. Non-convergence is a value.
struct NewtonResult {
  bool converged = false;
  int iterations = 0;
  int factorisations = 0;
  double residual = 0.0;      ///< |r|/f
  long negative_pivots = -1;  ///< of the last factorisation; -1 if the solver does not tell
  std::string reason;         ///< why it stopped, for the log
  std::optional<double>
      eigenvalue{};  ///< of the tangent in the lumped mass, nearest to zero, where a drape has looked [1/s^2]
};

class Newton {
 public:
  /// Creates the SNES, with defaults set before the user's options. Collective. The model must outlive it.
  explicit Newton(system::Model& model);
  ~Newton();
  Newton(const Newton&) = delete;
  Newton& operator=(const Newton&) = delete;

  /// Solves r(a) = 0 at the model's load factor, from and into `a`; on failure `a` is the last iterate. Collective.
  [[nodiscard]] NewtonResult step(Vec a);
  /// The same by pseudo-transient continuation. Collective.
  [[nodiscard]] NewtonResult continuation(Vec a, int max_iterations = 300);
  /// Called on every rank every few iterations of continuation with its number and |r|/f.
  void on_progress(std::function<void(int iteration, double residual)> progress);
  /// Begins a load step at state `a`: friction of contact acts against slips from here. Collective.
  void start_friction(Vec a);
  /// Solves again with friction that fits the state, until it does; `solve` is step or continuation. Collective.
  [[nodiscard]] NewtonResult settle_friction(Vec a, NewtonResult first, const std::function<NewtonResult()>& solve);
  /// Negative eigenvalues of the exact tangent at `a` (linear::LinearSolver::certain_negative_eigenvalues). Collective.
  [[nodiscard]] long negative_eigenvalues(Vec a);
  /// One linear solution K(a) da = -r(a): small deflections from the state `a`. Collective.
  [[nodiscard]] NewtonResult linear_step(Vec a);
  [[nodiscard]] SNES snes() const;
  [[nodiscard]] linear::LinearSolver& linear_solver();
  [[nodiscard]] const ConvergenceTest& convergence() const;

 private:
  struct Impl;
  /// step() from a state near the solution; on failure `a` and its residual are as before.
  [[nodiscard]] NewtonResult polish(Vec a);
  std::unique_ptr<Impl> impl_;
};

}  // namespace voile::solve

// Newton's method on a model at a fixed load factor, through PETSc's SNES.
//
// Symbols   r residual, K tangent, dx increment, f scale of forces (Model::force_scale), M lumped mass
// Stepping:      K(S*) dx = -r with S* the linearised stress of the previous iterate ("mixed integration point"
// tangent,
//                Magisano, Leonetti & Garcea, Comput. Methods Appl. Mech. Engng 313 (2017) 986-1005) and full steps:
//                few iterations, independent of the mesh, but the load step must be small enough.
// Continuation:  (K+ + s M) dx = -r, K+ with the tensile part of the stress, backtracking on the energy, s halved after
//                each full step: pseudo-transient continuation, which finds equilibria across snaps. Close to one the
//                exact tangent, with s raised while it is indefinite; Newton steps finish it.
// Converged:     |r| <= rtol f and |dx| <= stol |x - x0|  (-snes_rtol, -snes_stol; also |r| <= -snes_atol), or, where
//                the residual has reached its round-off, |dx| <= stol/1000 |x - x0| and |r.dx| <= rtol/1000 f |x - x0|,
//                or |r| <= eps |A| |X| sqrt(unknowns) (A membrane stiffness) and no longer falling.
// Linear solver: -ksp_type preonly -pc_type cholesky (lu with follower loads) -pc_factor_mat_solver_type mumps unless
//                the user says otherwise. MUMPS's lack of workspace is answered with twice as much, several times.
#pragma once

#include <memory>
#include <string>

#include "voile/system/model.hpp"

namespace voile::solve {

/// What came of a solve. Non-convergence is a value.
struct NewtonResult {
  bool converged = false;
  int iterations = 0;
  int factorisations = 0;
  double residual = 0.0;      ///< |r|/f
  long negative_pivots = -1;  ///< of the last factorisation; -1 if the solver does not tell
  std::string reason;         ///< why it stopped, for the log
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
  [[nodiscard]] NewtonResult continuation(Vec a);
  [[nodiscard]] SNES snes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voile::solve

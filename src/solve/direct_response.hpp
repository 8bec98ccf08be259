// Steady vibration of a whole model at one frequency, without modes.
//
// Symbols   K exact tangent at an equilibrium, M mass, C damping;  A = K - omega^2 M,  B = omega C;  f + i g force
//   (A + i B)(x + i y) = f + i g,   as the real symmetric system   [A -B; -B -A] [x; y] = [f; -g]
// MUMPS factors it anew at every frequency; where nothing damps, A alone.
// Source: R.W. Clough & J. Penzien, Dynamics of Structures, 3rd ed. (2003).
#pragma once

#include "eigen.hpp"

namespace voile::solve {

class DirectResponse {
 public:
  /// About `a`; `damping` may be null. They and the model must outlive it. Collective.
  DirectResponse(system::Model& model, Vec a, const MassMatrix& mass, Mat damping);
  /// x and y of a force (1 + i shift) f at an angular frequency [1/s]. Collective. Throws UserError if it is singular.
  void solve(double omega, Vec force, double shift, Vec x, Vec y) const;

 private:
  /// [A -B; -B -A].
  [[nodiscard]] petsc::MatHandle coupled(Mat a, double omega) const;

  const MassMatrix& mass_;
  Mat damping_;
  petsc::MatHandle stiffness_;
};

}  // namespace voile::solve

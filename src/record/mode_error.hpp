// By how much an eigenvalue is off, by estimate.
//
// Symbols   phi   a mode;  W = 1/2 phi.K phi, its energy [J];  omega^2 its eigenvalue
//           d     energy by which its stress resultants differ from smooth ones (discretisation_error.hpp)  [J]
//           s, m  what its cells count too much (energy/slope_error.hpp), of N or of the critical N [J], and of mass [kg m^2]
//   error = (d + |s - 1/2 omega^2 m|) / W
// A consistent mass counts as far as bending does not carry the mode: in bending, what it lacks the curvature lacks too.
#pragma once

#include <array>
#include <vector>

#include "discretisation_error.hpp"
#include "solve/eigen.hpp"

namespace voile::record {

class ModeErrors {
 public:
  /// About the state `a`, of modes of vibration with masses of that kind. Everything given must outlive it. Collective.
  ModeErrors(system::Model& model, Vec a, system::Mass kind);
  /// Of modes of buckling, which the response to the load factor leads to. Collective.
  ModeErrors(system::Model& model, Vec a, Vec response);

  /// Relative error of the eigenvalue; on rank 0, 0 elsewhere. Collective.
  [[nodiscard]] double of(const solve::Mode& mode);

 private:
  struct Excess {
    double slopes = 0.0, mass = 0.0;
  };
  [[nodiscard]] Excess excess_of(const solve::Mode& mode, const system::TriangleFields& fields,
                                 const std::vector<double>& force) const;

  system::Model& model_;
  Vec a_;
  bool vibration_, lumped_ = false;
  std::vector<double> force_, force_per_load_;  ///< N of the state, and what a load factor of 1 adds [N/m]; on rank 0
  std::vector<double> place_;                   ///< displacements of the vertices in the state [m]; likewise
  std::vector<std::array<Vec2, 3>> corners_;    ///< of each triangle at rest, in its material axes [m]; likewise
  DiscretisationError recovery_;
};

}  // namespace voile::record

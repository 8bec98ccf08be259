// What supports bear in a vibration about a state.
//
// Symbols   q   displacement, zero where it is held;  c_h, m_h   rows of what is held in damping and mass
//           f   internal minus applied forces there;  s load factor of what vibrates;  b acceleration of the base
//   R = (df/dq - omega^2 m_h + i omega c_h) q + df/ds,   of a moving base  + m_h b (1 + alpha / (i omega)) instead of df/ds
// Damping by ratios of modes has no place in the sheet, and no row here.
// Source: R.W. Clough & J. Penzien, Dynamics of Structures, 3rd ed. (2003), 26.
#pragma once

#include "solve/eigen.hpp"
#include "system/dynamics.hpp"
#include "system/model.hpp"

namespace voile::record {

class SupportForces {
 public:
  /// About `a`, with the damping of `options`. The model and `a` must outlive it. Collective.
  SupportForces(system::Model& model, Vec a, const system::DynamicsOptions& options, const solve::MassMatrix& mass);

  /// Of one displacement: the three factors of R, zero where nothing is held [N/m, N s/m, kg].
  struct Rows {
    petsc::VecHandle stiffness, damping, inertia;
  };
  /// Collective.
  [[nodiscard]] Rows of(Vec q);
  /// df/ds. Collective. [N]
  [[nodiscard]] petsc::VecHandle of_loads();
  /// m_h b. Collective. [N]
  [[nodiscard]] petsc::VecHandle of_base(const Vec3& acceleration);

 private:
  [[nodiscard]] petsc::VecHandle held(petsc::VecHandle f) const;

  system::Model& model_;
  Vec a_;
  system::Dynamics dynamics_;
};

}  // namespace voile::record

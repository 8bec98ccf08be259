// What makes a sheet vibrate: loads, or a base that moves.
#pragma once

#include "input/case.hpp"
#include "system/model.hpp"
#include "system/rigid_inertia.hpp"

namespace voile::simulation {

struct Excitation {
  petsc::VecHandle force;     ///< on the free unknowns [N]
  Vec3 base = Vec3::Zero();   ///< acceleration of the base [m/s^2]
  double mass_damping = 0.0;  ///< that acts on its velocity too [1/s]
  /// The part of the force that is ahead by a quarter of the circle.
  [[nodiscard]] double shift(double omega) const { return -mass_damping / omega; }
};

/// About the state `a`. Collective. Throws UserError where no load acts.
[[nodiscard]] Excitation excitation_of(const input::Case& c, system::Model& model, Vec a,
                                       const system::RigidInertia& inertia);
/// Throws UserError for temperatures and folds that are no straight line of t where buckling and vibrations take their growth. Not
/// collective.
void require_straight(const input::Case& c, const mesh::SurfaceMesh& mesh);
/// Does that, and throws UserError for supports that move by themselves, and a base that cannot move the sheet, if the analysis is one of
/// frequencies. Not collective.
void require_excitation(const input::Case& c, const system::Model& model);

}  // namespace voile::simulation

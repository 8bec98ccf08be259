// Inertia of a sheet that moves as one rigid body: what moving supports load it with, and what modes take part in.
//
// Symbols   r_k   rigid motion: k < 3 translation along axis k, k >= 3 turning about axis k - 3 through the centre of mass,
//                 all vertices alike, held ones included                                                [1], [m/rad]
//           M     mass without elimination;  phi mode, zero where the displacement is held
//   f_k = M r_k                    force of inertia at a unit acceleration                          [kg], [kg m]
//   L_k = phi.f_k,  m = phi.M phi,  effective mass L_k^2/m, whose sum over all modes is the mass that moves freely
// Source: R.W. Clough & J. Penzien, Dynamics of Structures, 3rd ed. (2003), 26.
#pragma once

#include <array>

#include "dynamics_options.hpp"
#include "model.hpp"

namespace voile::system {

struct RigidInertia {
  static constexpr std::size_t motions = 6;
  double mass = 0.0;                            ///< of everything, held vertices included [kg]
  Vec3 centre = Vec3::Zero();                   ///< of mass, in the state [m]
  Vec3 moments = Vec3::Zero();                  ///< of inertia about the axes through it [kg m^2]
  std::array<petsc::VecHandle, motions> force;  ///< f_k
  /// Of everything in motion k: the mass, or the moment of inertia.
  [[nodiscard]] double whole(std::size_t k) const { return k < 3 ? mass : moments[static_cast<Eigen::Index>(k) - 3]; }
};

/// In the state `a`. Collective. The materials have a mass.
[[nodiscard]] RigidInertia rigid_inertia(Model& model, Vec a, Mass kind);

}  // namespace voile::system

// The natural state of a triangle: the strain and curvature at which it is without force, where that is not its rest shape.
//
// Symbols   dT, d     change of temperature; difference of temperature, top less bottom (the normal points to the top)  [K]
//           eps, a    initial strain and expansion of the material, a strain and a strain per kelvin, in its axes
//           k_T       curvature per difference of temperature [1/(m K)];  of a plate of thickness h -a/h
//           N0        prestress: membrane force of the rest shape, in its axes [N/m];  A membrane stiffness [N/m]
//           U         I + sym(eps + a dT), stretch from rest to the natural state
//   half the metric of the natural state   U m U - A^-1 N0,      m that of the rest shape
//   its curvature                          U^1/2 kappa0 U^1/2 + k_T d
//   to first order, with E = U - I         m + E m + m E - A^-1 N0,   kappa0 + (E kappa0 + kappa0 E)/2 + k_T d
// Where stretching and bending are coupled a change has a curvature as well, a difference a strain, and N0 a curvature that leaves no
// moment. With one expansion in all directions a curved sheet grows to a similar one: kappa0 by the coordinates of the rest shape grows
// by the stretch. The membrane strain E - (natural) and the curvature less the natural one are the elastic ones.
// Theory: docs/theory/curved-rest-shapes.md, natural states.
#pragma once

#include "base/types.hpp"
#include "material.hpp"

namespace voile::energy {

struct NaturalState {
  Mat2 stretch = Mat2::Identity();  ///< U
  bool first_order = false;         ///< of U - I: linear analysis, which leaves its square out of all strains
  Vec3 prestrain = Vec3::Zero();    ///< -A^-1 N0, engineering shear
  Vec3 curvature = Vec3::Zero();    ///< k_T d [1/m]

  /// The natural counterpart of half a metric (m11, m22, 2 m12) of the rest shape.
  [[nodiscard]] Vec3 metric(const Vec3& rest) const;
  /// The natural counterpart of a curvature (k11, k22, 2 k12) of the rest shape [1/m].
  [[nodiscard]] Vec3 bent(const Vec3& rest) const;
};

/// Of a material at temperatures dT and d [K].
[[nodiscard]] NaturalState natural_state(const Material& material, double change, double difference);
/// The material as a law of strains from its rest shape, where yarns stiffen or rub or the law is hyperelastic: it holds from the natural
/// state, so that with an initial strain it sees T E, of U^-1 E U^-1, on an area of det U:
///   A -> det U T^T A T, and YarnLaw::natural, YarnLaw::area likewise, and those of Hyperelastic
/// Others stay: their law is linear, and what T changes is of the order of what a linear law leaves out.
[[nodiscard]] Material in_natural_frame(Material material);
/// Whether it has an initial strain or a prestress.
[[nodiscard]] bool has_initial_state(const Material& material);

}  // namespace voile::energy

// Incompressible hyperelastic sheets in plane stress: large strains of rubber.
//
// Symbols   C       I + 2 E, right Cauchy-Green tensor of the sheet; its eigenvalues are l1^2 and l2^2, squares of the stretches
//           J       det C = (l1 l2)^2;  the thickness shrinks by l3 = 1/(l1 l2)
//           c10, c01, mu_p   moduli of the law times the thickness at rest                                        [N/m]
//   w = c10 (l1^2 + l2^2 + l3^2 - 3) + c01 (1/l1^2 + 1/l2^2 + 1/l3^2 - 3)            per area at rest; Mooney-Rivlin, neo-Hooke c01 = 0
//     + sum_p mu_p/alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3)                Ogden
// The stiffness at zero strain is that of an isotropic sheet with nu = 1/2 and the shear modulus c10 2 + c01 2 + sum mu_p alpha_p/2.
// Membrane forces N = dw/dE are those of the second Piola-Kirchhoff stress; the true stress in the axes that turn with the sheet
// (F = R V) is V N V/h.
// Source: Holzapfel, Nonlinear Solid Mechanics (2000), 6.5 and 6.6. Theory: docs/theory/membrane.md, rubber.
#pragma once

#include <vector>

#include "base/types.hpp"

namespace voile::energy {

struct Hyperelastic {
  struct Term {
    double modulus = 0.0;   ///< mu_p [N/m]
    double exponent = 0.0;  ///< alpha_p
  };
  double c10 = 0.0, c01 = 0.0;  ///< [N/m]
  std::vector<Term> terms{};    ///< Ogden
  /// As in YarnLaw: strains from the rest shape to those from the natural state, and the area of that over the area of the rest shape.
  Mat3 natural = Mat3::Identity();
  double area = 1.0;

  [[nodiscard]] bool any() const { return c10 != 0.0 || c01 != 0.0 || !terms.empty(); }
  /// At zero strain, times the thickness [N/m].
  [[nodiscard]] double shear_modulus() const;
  void scale(double factor);
};

/// What a law answers to a strain in material axes, per area at rest.
struct HyperelasticResponse {
  double energy = 0.0;          ///< w [N/m]
  Vec3 force = Vec3::Zero();    ///< N = dw/dE [N/m]
  Mat3 tangent = Mat3::Zero();  ///< d2w/dE2 [N/m]
  /// Whether C is positive definite; otherwise the numbers are not a number.
  bool possible = true;
};
[[nodiscard]] HyperelasticResponse response(const Hyperelastic& law, const Vec3& strain);

/// Principal stretches of a strain, the larger first; of an impossible one 0 for the square root of less than 0.
struct Stretches {
  double most = 1.0, least = 1.0;
};
[[nodiscard]] Stretches stretches_of(const Vec3& strain);
/// Thickness over that at rest.
[[nodiscard]] double thinning(const Hyperelastic& law, const Vec3& strain);
/// True membrane force per present width and present thickness over that at rest, i.e. V N V, in axes that turn with the sheet [N/m].
[[nodiscard]] Vec3 true_force(const Hyperelastic& law, const Vec3& strain);
/// Least stiffness of a wave in the plane of the sheet over the shear modulus at rest: not above zero where the law has lost
/// ellipticity. Over all directions of the wave.
[[nodiscard]] double ellipticity(const Hyperelastic& law, const Vec3& strain);

}  // namespace voile::energy

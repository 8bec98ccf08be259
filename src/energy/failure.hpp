// When a ply fails: strengths and criteria in plane stress.
//
// Symbols   s = (s1, s2, t)   stress along the fibres, across them, and shear                                     [Pa]
//           X, X'  Y, Y'  S   strengths along, across (in tension, in compression, all > 0), and in shear         [Pa]
// A criterion allows the stress to grow by a factor R before the ply fails; the index is 1/R: in proportion to the stress, 1 at
// failure.
//   maximum stress  max(s1/X or -s1/X', s2/Y or -s2/Y', |t|/S)
//   maximum strain  the same of e = Q^-1 s with X/E1, X'/E1, Y/E2, Y'/E2, S/G12
//   Tsai-Wu         a R^2 + b R = 1,  a = s1^2/(X X') + s2^2/(Y Y') + t^2/S^2 - s1 s2/sqrt(X X' Y Y'),
//                   b = s1 (1/X - 1/X') + s2 (1/Y - 1/Y')
//   Hashin          fibres: (s1/X)^2 + (t/S)^2 in tension, (s1/X')^2 in compression; matrix: (s2/Y)^2 + (t/S)^2 in tension,
//                   (s2/Y')^2 + (t/S)^2 in compression, with Y'/2 for the shear strength across the fibres; roots of the largest
// Source: Tsai & Wu, J. Compos. Mater. 5 (1971) 58-80; Hashin, J. Appl. Mech. 47 (1980) 329-334; Jones, Mechanics of Composite
// Materials, 2nd ed. (1999), 2.9.
#pragma once

#include "base/types.hpp"

namespace voile::energy {

struct Strength {
  enum class Criterion { tsai_wu, hashin, maximum_stress, maximum_strain };
  Criterion criterion = Criterion::tsai_wu;
  double tensile_1 = 0.0, compressive_1 = 0.0, tensile_2 = 0.0, compressive_2 = 0.0, shear = 0.0;  ///< [Pa]
  double young_1 = 0.0, young_2 = 0.0, poisson_12 = 0.0, shear_12 = 0.0;  ///< of the ply, for strains [Pa]
};

/// 1/R of the stress (s1, s2, t) in the axes of the ply.
[[nodiscard]] double failure_index(const Strength& strength, const Vec3& stress);
/// Stress in axes that lie at `angle` [rad] to those in which it is given.
[[nodiscard]] Vec3 turned_stress(const Vec3& stress, double angle);

}  // namespace voile::energy

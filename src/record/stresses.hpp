// Stresses through the thickness from membrane strains and curvatures.
//
// Symbols   z   distance from the middle along the normal [m];  Q  plane-stress stiffness of the layer [Pa]
//           E, kappa   membrane strain and change of curvature, order 11, 22, 12 with engineering shear, material axes
//   sigma(z) = Q (E - z kappa)    (a surface that bends towards its normal is pressed on that side)
// and of hyperelastic sheets true stresses: energy/layer_stress.hpp.
#pragma once

#include <vector>

#include "energy/sheet.hpp"
#include "results/results.hpp"
#include "system/model.hpp"

namespace voile::record {

/// Fields on triangles: stress_top and stress_bottom (11, 22, 12), principal_stress_top and _bottom (s1, s2, angle of
/// s1 to material axis 1 [rad]), von_mises_top and _bottom; `plies`: also ply_stress_<k>_bottom and _top. Zero where a
/// material's layers are not known. Rank 0 only.
[[nodiscard]] std::vector<results::Field> stress_fields(const energy::Sheet& sheet,
                                                        const system::TriangleFields& fields, bool plies);

/// Stress 11, 22, 12 on a face of a triangle; zero where the layers are not known. Rank 0 only. [Pa]
[[nodiscard]] Vec3 face_stress(const energy::Sheet& sheet, const system::TriangleFields& fields, Index triangle,
                               bool top);
/// Of a stress 11, 22, 12. [Pa]
[[nodiscard]] double von_mises(const Vec3& stress);

/// principal_stretch on triangles: those of the sheet, the larger first, and of its thickness; 1 where the material is not hyperelastic. None
/// if no material is. Rank 0 only.
[[nodiscard]] std::vector<results::Field> stretch_fields(const energy::Sheet& sheet,
                                                         const system::TriangleFields& fields);

}  // namespace voile::record

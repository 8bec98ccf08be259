// Stresses in the layers of a sheet, and which layer fails first.
//
// Symbols   e, k   elastic strain (engineering shear) and curvature of the sheet in material axes               [-], [1/m]
//           z      height above the middle [m];  Q stiffness of the layer in material axes [Pa]
//           T, dT  change of temperature and difference between top and bottom                                        [K]
//   s(z) = Q (e - z k + what the layer wants to expand otherwise than the sheet under T and dT)
// Of a hyperelastic sheet (hyperelastic.hpp) V N V/h - z Q k: the true stress of stretching, in axes that turn with the sheet, and that of
// bending as at zero strain.
// Source: Jones, Mechanics of Composite Materials, 2nd ed. (1999), chapter 4.
#pragma once

#include "material.hpp"

namespace voile::energy {

struct SheetState {
  Vec3 strain = Vec3::Zero(), curvature = Vec3::Zero();
  double change = 0.0, difference = 0.0;  ///< T, dT
};

/// At height z in a layer of the material, in material axes [Pa].
[[nodiscard]] Vec3 layer_stress(const Material& material, const Layer& layer, double z, const SheetState& state);

/// The face of a layer where the index (failure.hpp) is largest.
struct LayerFailure {
  double index = 0.0;
  int layer = 0;  ///< from 1, the lowest; 0: there is no stress
  bool top = false;
};
/// Of a material with a strength.
[[nodiscard]] LayerFailure worst_layer(const Material& material, const SheetState& state);

}  // namespace voile::energy

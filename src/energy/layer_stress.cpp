#include "layer_stress.hpp"

namespace voile::energy {

Vec3 layer_stress(const Material& m, const Layer& layer, double z, const SheetState& state) {
  const double thickness = m.layers.back().high - m.layers.front().low;
  if (m.rubber.any())
    return true_force(m.rubber, state.strain) / thickness - z * Vec3(layer.stiffness * state.curvature);
  Vec3 elastic = state.strain - z * state.curvature;
  elastic += state.change * (m.expansion - layer.expansion - z * m.coupled_curvature) +
             state.difference * (m.coupled_strain - z * (m.expansion_curvature + layer.expansion / thickness));
  return layer.stiffness * elastic;
}

LayerFailure worst_layer(const Material& m, const SheetState& state) {
  LayerFailure worst;
  for (std::size_t k = 0; k < m.layers.size(); ++k)
    for (const bool top : {false, true}) {
      const Layer& layer = m.layers[k];
      const Vec3 stress = layer_stress(m, layer, top ? layer.high : layer.low, state);
      const double index = failure_index(*m.strength, turned_stress(stress, layer.angle));
      if (index > worst.index) worst = {index, static_cast<int>(k) + 1, top};
    }
  return worst;
}

}  // namespace voile::energy

#include "failure.hpp"

#include <algorithm>

#include "energy/sheet.hpp"

namespace voile::system {

bool has_strengths(const energy::Sheet& sheet) {
  const auto& materials = sheet.materials();
  return std::any_of(materials.begin(), materials.end(),
                     [](const energy::Material& m) { return m.strength.has_value() && !m.layers.empty(); });
}

energy::SheetState sheet_state(const TriangleFields& fields, std::size_t t) {
  energy::SheetState state{Eigen::Map<const Vec3>(fields.membrane_strain.data() + 3 * t),
                           Eigen::Map<const Vec3>(fields.curvature.data() + 3 * t)};
  if (fields.temperature.empty()) return state;
  state.change = fields.temperature[2 * t];
  state.difference = fields.temperature[2 * t + 1];
  return state;
}

FailureFields failure_fields(const energy::Sheet& sheet, const TriangleFields& fields) {
  const std::size_t triangles = fields.membrane_strain.size() / 3;
  FailureFields f;
  f.index.assign(triangles, 0.0);
  f.ply.assign(triangles, 0.0);
  for (std::size_t t = 0; t < triangles; ++t) {
    const energy::Material& m = sheet.material(static_cast<Index>(t));
    if (!m.strength || m.layers.empty()) continue;
    const energy::LayerFailure worst = energy::worst_layer(m, sheet_state(fields, t));
    f.index[t] = worst.index;
    f.ply[t] = worst.layer;
    if (worst.index <= f.first.index) continue;
    f.first = worst;
    f.triangle = static_cast<Index>(t);
  }
  return f;
}

}  // namespace voile::system

#include "panel_measures.hpp"

namespace voile::setup {

std::vector<PanelMeasures> measure_panels(const mesh::SurfaceMesh& mesh, const std::vector<energy::Material>& materials,
                                          const std::vector<system::SeamRule>& seams) {
  const std::vector<int> material_of = energy::assign_materials(mesh, materials);
  const std::vector<double> allowances = system::allowance_areas(mesh, seams);
  std::vector<PanelMeasures> panels;
  for (const mesh::Group& group : mesh.groups()) {
    if (group.dimension != 2) continue;
    PanelMeasures panel{group.name, 0.0, 0.0, 0.0};
    for (const Index t : group.triangles) {
      const double allowance = allowances.empty() ? 0.0 : allowances[t];
      panel.area += mesh.area(t);
      panel.allowance += allowance;
      panel.mass += (mesh.area(t) + allowance) * materials[static_cast<std::size_t>(material_of[t])].areal_density;
    }
    panels.push_back(std::move(panel));
  }
  return panels;
}

}  // namespace voile::setup

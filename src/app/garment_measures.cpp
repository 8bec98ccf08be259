#include "garment_measures.hpp"

#include <algorithm>

#include "base/mpi.hpp"
#include "base/text.hpp"
#include "contact_fields.hpp"
#include "mesh/weld.hpp"
#include "model_input.hpp"
#include "system/contact.hpp"

namespace voile::app {

namespace {

/// Of all seams but those that a later stage sews.
std::vector<system::SeamTension> tensions(const input::Case& c, const system::Model& model,
                                          const std::vector<double>& displacement, const std::vector<double>& force) {
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  std::vector<Vec3> places = mesh.positions();
  for (std::size_t v = 0; v < places.size(); ++v) places[v] += Eigen::Map<const Vec3>(&displacement[3 * v]);
  const std::vector<std::string> open = mesh::open_seams(mesh.data(), {"all"}),
                                 sewn = mesh::open_seams(mesh.data(), c.stage.sew);
  std::vector<system::SeamTension> all;
  const std::string prefix = mesh::seam_group("");
  for (const mesh::Group& group : mesh.groups()) {
    if (group.dimension != 1 || !group.name.starts_with(prefix)) continue;
    const std::string name = group.name.substr(prefix.size());
    if (contains(open, name) && !contains(sewn, name)) continue;
    all.push_back(system::seam_tension(model.discretisation().sheet(), group, force, places));
    all.back().name = name;
  }
  return all;
}

}  // namespace

std::vector<GarmentMeasures::Panel> measure_panels(const mesh::SurfaceMesh& mesh,
                                                   const std::vector<energy::Material>& materials,
                                                   const std::vector<system::SeamRule>& seams) {
  const std::vector<int> material_of = energy::assign_materials(mesh, materials);
  const std::vector<double> allowances = system::allowance_areas(mesh, seams);
  std::vector<GarmentMeasures::Panel> panels;
  for (const mesh::Group& group : mesh.groups()) {
    if (group.dimension != 2) continue;
    GarmentMeasures::Panel panel{group.name, 0.0, 0.0, 0.0};
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

GarmentMeasures measure_garment(const input::Case& c, system::Model& model, const system::State& state) {
  GarmentMeasures m;
  const std::vector<double> displacement = model.dofs().gather(state.u);
  const system::TriangleFields fields = model.potential().triangle_fields(state.u);
  std::vector<double> ease, pressure;
  for (io::Field& f : contact_fields(
           model, state.u, [](const std::string& name) { return name == "ease" || name == "contact_pressure"; }))
    (f.name == "ease" ? ease : pressure) = std::move(f.values);
  mpi::on_root(model.dofs().comm(), [&] {
    m.panels = measure_panels(model.dofs().mesh(), c.materials, seam_rules(c));
    m.seams = tensions(c, model, displacement, fields.membrane_force);
    if (!ease.empty()) m.ease = system::range_of_ease(model.contact()->scene(), ease, {});
    if (!pressure.empty()) m.largest_pressure = *std::max_element(pressure.begin(), pressure.end());
  });
  return m;
}

}  // namespace voile::app

#include "garment_measures.hpp"

#include <algorithm>

#include "base/mpi.hpp"
#include "base/text.hpp"
#include "contact_fields.hpp"
#include "mesh/weld.hpp"
#include "setup/model_input.hpp"
#include "system/contact.hpp"

namespace voile::record {

namespace {

std::vector<Vec3> places_of(const mesh::SurfaceMesh& mesh, const std::vector<double>& displacement) {
  std::vector<Vec3> places = mesh.positions();
  for (std::size_t v = 0; v < places.size(); ++v) places[v] += Eigen::Map<const Vec3>(&displacement[3 * v]);
  return places;
}

/// Of all seams but those that a later stage sews.
std::vector<system::SeamTension> tensions(const input::Case& c, const system::Model& model,
                                          const std::vector<double>& displacement, const std::vector<double>& force) {
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  const std::vector<Vec3> places = places_of(mesh, displacement);
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

GarmentMeasures measure_garment(const input::Case& c, system::Model& model, const system::State& state) {
  GarmentMeasures m;
  const std::vector<double> displacement = model.dofs().gather(state.u);
  const system::TriangleFields fields = model.triangle_fields(state.u);
  std::vector<double> ease, pressure;
  for (results::Field& f : contact_fields(
           model, state.u, [](const std::string& name) { return name == "ease" || name == "contact_pressure"; }))
    (f.name == "ease" ? ease : pressure) = std::move(f.values);
  mpi::on_root(model.dofs().comm(), [&] {
    m.panels = setup::measure_panels(model.dofs().mesh(), c.materials, setup::seam_rules(c));
    m.seams = tensions(c, model, displacement, fields.membrane_force);
    if (!ease.empty()) m.ease = system::range_of_ease(model.contact()->scene(), ease, {});
    if (!pressure.empty()) m.largest_pressure = *std::max_element(pressure.begin(), pressure.end());
  });
  return m;
}

double seam_gap(const input::Case& c, const mesh::SurfaceMesh& mesh, const std::vector<double>& displacement) {
  if (displacement.empty()) return 0.0;
  const std::vector<std::string> open = mesh::open_seams(mesh.data(), c.stage.sew);
  return mesh::widest_gap(mesh.data(), open, places_of(mesh, displacement)).gap;
}

}  // namespace voile::record

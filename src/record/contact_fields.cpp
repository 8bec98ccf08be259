#include "contact_fields.hpp"

#include <cmath>
#include <utility>

#include "system/contact.hpp"
#include "system/ease.hpp"

namespace voile::record {

namespace {

/// Force on each vertex of the sheet. Collective. [N]
std::vector<double> forces(system::Model& model, Vec a, contact::ContactSet::Part part) {
  petsc::VecHandle f = model.dofs().create_vector();
  model.contact()->add_gradient(a, f, part);
  VOILE_PETSC(VecScale(f, -1.0));
  return model.dofs().gather(f);
}

}  // namespace

std::vector<io::Field> contact_fields(system::Model& model, Vec a,
                                      const std::function<bool(const std::string&)>& wants) {
  std::vector<io::Field> fields;
  const system::Contact* contact = model.contact();
  if (!contact) return fields;
  std::vector<double> normal = forces(model, a, contact::ContactSet::normal), pressure(normal.size() / 3);
  for (std::size_t v = 0; v < pressure.size(); ++v)
    pressure[v] =
        std::hypot(normal[3 * v], normal[3 * v + 1], normal[3 * v + 2]) / contact->scene().set().surface().area[v];
  if (wants("contact_pressure")) fields.push_back({"contact_pressure", "Pa", io::Centre::vertex, 1, pressure});
  if (system::has_yielding_obstacles(contact->scene().input()) && wants("gives_way")) {
    std::vector<double> given(pressure.size());
    const std::vector<double>& yielding = contact->memory().yielding;
    for (std::size_t v = 0; v < given.size() && v < yielding.size(); ++v) given[v] = yielding[v] != 0.0 ? 1.0 : 0.0;
    fields.push_back({"gives_way", "1", io::Centre::vertex, 1, std::move(given)});
  }
  if (wants("contact_force")) fields.push_back({"contact_force", "N", io::Centre::vertex, 3, std::move(normal)});
  if (wants("friction_force"))
    fields.push_back({"friction_force", "N", io::Centre::vertex, 3, forces(model, a, contact::ContactSet::friction)});
  if (system::has_bodies(contact->scene().input()) && wants("ease"))
    fields.push_back({"ease", "m", io::Centre::vertex, 1, system::ease(contact->scene(), a)});
  return fields;
}

}  // namespace voile::record

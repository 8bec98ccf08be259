#include "contact_fields.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "system/contact.hpp"
#include "system/ease.hpp"

namespace voile::record {

namespace {

/// Force on each vertex of the sheet. Collective. [N]
std::vector<double> forces(system::Model& model, Vec a, contact::ContactSet::Part part, double* size = nullptr) {
  petsc::VecHandle f = model.dofs().create_vector();
  const double norm = model.contact()->add_gradient(a, f, part);
  if (size) *size = norm;
  VOILE_PETSC(VecScale(f, -1.0));
  return model.dofs().gather(f);
}

}  // namespace

std::vector<results::Field> contact_fields(system::Model& model, Vec a,
                                           const std::function<bool(const std::string&)>& wants) {
  std::vector<results::Field> fields;
  const system::Contact* contact = model.contact();
  if (!contact) return fields;
  double pressed = 0.0;
  std::vector<double> normal = forces(model, a, contact::ContactSet::normal, &pressed), pressure(normal.size() / 3);
  if (wants("contact_pressure")) {
    const auto raise = [&](const std::vector<double>& f) {
      for (std::size_t v = 0; v < pressure.size(); ++v)
        pressure[v] = std::max(
            pressure[v], std::hypot(f[3 * v], f[3 * v + 1], f[3 * v + 2]) / contact->scene().set().surface().area[v]);
    };
    raise(normal);  // an edge that is pressed in its plane has a part of that on either face
    for (const auto face : {contact::ContactSet::lower_face, contact::ContactSet::upper_face})
      raise(forces(model, a, face));
    fields.push_back({"contact_pressure", "Pa", results::Centre::vertex, 1, pressure});
  }
  if (system::has_passable_obstacles(contact->scene().input()) && wants("passing")) {
    std::vector<double> given(pressure.size());
    const std::vector<double>& passing = contact->memory().passing;
    for (std::size_t v = 0; v < given.size() && v < passing.size(); ++v) given[v] = passing[v] != 0.0 ? 1.0 : 0.0;
    fields.push_back({"passing", "1", results::Centre::vertex, 1, std::move(given)});
  }
  if (wants("contact_force")) fields.push_back({"contact_force", "N", results::Centre::vertex, 3, std::move(normal)});
  const bool known = contact->scene().set().knows_friction() || pressed == 0.0;  // not of a state from elsewhere
  if (wants("friction_force") && known)
    fields.push_back(
        {"friction_force", "N", results::Centre::vertex, 3, forces(model, a, contact::ContactSet::friction)});
  if (system::has_bodies(contact->scene().input()) && wants("ease"))
    fields.push_back({"ease", "m", results::Centre::vertex, 1, system::ease(contact->scene(), a)});
  return fields;
}

}  // namespace voile::record

#include "field_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "voile/errors.hpp"

namespace voile::picture {

namespace {

/// Names of the components, the default first; those that are computed have no number.
struct Component {
  std::string name;
  double (*value)(const double* row, double shear);
  const char* unit = nullptr;  ///< null: that of the field
};

double larger(const double* r, double shear) {
  return 0.5 * (r[0] + r[1]) + std::hypot(0.5 * (r[0] - r[1]), shear * r[2]);
}
double smaller(const double* r, double shear) {
  return 0.5 * (r[0] + r[1]) - std::hypot(0.5 * (r[0] - r[1]), shear * r[2]);
}

double larger_in_size(const double* r, double shear) {
  return std::max(std::abs(larger(r, shear)), std::abs(smaller(r, shear)));
}
/// By how much a line gets longer, from its Green-Lagrange strain. [%]
double elongation(double strain) {
  return 100.0 * (std::sqrt(std::max(0.0, 1.0 + 2.0 * strain)) - 1.0);
}

template <int k>
double entry(const double* r, double) {
  return r[k];
}

/// Of three numbers, as vectors on vertices; what is recovered there are tensors.
bool is_vector(const results::Field& field) {
  return field.components == 3 && field.centre == results::Centre::vertex && !field.name.ends_with("_at_vertices");
}

std::vector<Component> components_of(const results::Field& field) {
  if (field.components == 1) return {{"", entry<0>}};
  if (is_vector(field))
    return {{"magnitude", [](const double* r, double) { return std::hypot(r[0], r[1], r[2]); }},
            {"x", entry<0>},
            {"y", entry<1>},
            {"z", entry<2>}};
  if (field.name == "principal_stretch") return {{"larger", entry<0>}, {"smaller", entry<1>}, {"thickness", entry<2>}};
  if (field.components == 3 && field.name.starts_with("principal_"))
    return {{"larger", entry<0>}, {"smaller", entry<1>}, {"angle", entry<2>}};
  if (field.name == "membrane_strain")
    return {{"larger", larger},
            {"smaller", smaller},
            {"max", larger_in_size},
            {"11", entry<0>},
            {"22", entry<1>},
            {"12", entry<2>},
            {"warp", [](const double* r, double) { return elongation(r[0]); }, "%"},
            {"weft", [](const double* r, double) { return elongation(r[1]); }, "%"},
            {"stretch", [](const double* r, double s) { return elongation(larger(r, s)); }, "%"}};
  if (field.components == 3)
    return {{"larger", larger}, {"smaller", smaller}, {"max", larger_in_size},
            {"11", entry<0>},   {"22", entry<1>},     {"12", entry<2>}};
  return {{"1", entry<0>}, {"2", entry<1>}, {"3", entry<2>}, {"4", entry<3>}, {"5", entry<4>},
          {"6", entry<5>}, {"7", entry<6>}, {"8", entry<7>}, {"9", entry<8>}};
}

/// The first two from material axes to the threads, warp_angle beyond.
void turn_to_threads(results::Field& strain, const mesh::MeshData& mesh, const std::vector<SheetMaterial>& materials) {
  if (materials.empty() || strain.values.size() != 3 * mesh.triangles.size()) return;
  const std::vector<std::size_t> of = materials_of(mesh, materials);
  for (std::size_t t = 0; t < of.size(); ++t) {
    const double angle = materials[of[t]].warp_angle, c = std::cos(angle), s = std::sin(angle);
    double* e = strain.values.data() + 3 * t;
    const double sum = e[0] + e[1];
    e[0] = c * c * e[0] + s * s * e[1] + s * c * e[2];
    e[1] = sum - e[0];
  }
}

}  // namespace

FieldValues field_values(const Recording& recording, const Moment& moment, const FieldChoice& choice) {
  const mesh::MeshData& mesh = recording.mesh(moment)->data;
  results::Field field = recording.parts()[moment.part].run.field(*moment.step, choice.name, mesh);
  if (field.name == "membrane_strain" && (choice.component == "warp" || choice.component == "weft"))
    turn_to_threads(field, mesh, recording.materials());
  return field_values(field, choice.component);
}

FieldChoice parse_field(const std::string& text) {
  const std::size_t colon = text.find(':');
  return {text.substr(0, colon), colon == std::string::npos ? "" : text.substr(colon + 1)};
}

std::vector<std::string> entry_names(const results::Field& field) {
  if (field.components == 1) return {""};
  if (is_vector(field)) return {"x", "y", "z"};
  if (field.name == "principal_stretch") return {"larger", "smaller", "thickness"};
  if (field.components == 3 && field.name.starts_with("principal_")) return {"larger", "smaller", "angle"};
  if (field.components == 3) return {"11", "22", "12"};
  std::vector<std::string> names;
  for (int k = 1; k <= field.components; ++k) names.push_back(std::to_string(k));
  return names;
}

FieldValues field_values(const results::Field& field, const std::string& component) {
  const std::vector<Component> all = components_of(field);
  auto chosen = all.begin();
  if (!component.empty()) {
    chosen = std::find_if(all.begin(), all.end(), [&](const Component& c) { return c.name == component; });
    if (chosen == all.end()) {
      std::vector<std::string> names;
      for (const Component& c : all) names.push_back(c.name);
      throw UserError(all.size() == 1 ? fmt::format("--field {}: it has no components", field.name)
                                      : fmt::format("--field {}:{}: it has the components {}", field.name, component,
                                                    join(names, ", ")));
    }
  }
  // Strains and curvatures have twice the tensor's component as their third.
  const double shear = field.name == "membrane_strain" || field.name == "curvature" ? 0.5 : 1.0;
  const auto columns = static_cast<std::size_t>(field.components);
  const std::string unit = chosen->unit              ? chosen->unit
                           : chosen->name == "angle" ? "rad"
                                                     : field.unit.substr(0, field.unit.find(','));
  FieldValues result;
  result.label =
      field.name + (chosen->name.empty() ? "" : ", " + chosen->name) + (unit == "1" ? "" : fmt::format(" [{}]", unit));
  std::replace(result.label.begin(), result.label.end(), '_', ' ');
  result.on_triangles = field.centre == results::Centre::triangle;
  for (std::size_t i = 0; i + columns <= field.values.size(); i += columns)
    result.values.push_back(static_cast<float>(chosen->value(field.values.data() + i, shear)));
  return result;
}

}  // namespace voile::picture

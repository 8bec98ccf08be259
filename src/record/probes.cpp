#include "probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/closest_triangle.hpp"
#include "mesh/group_weights.hpp"
#include "stresses.hpp"
#include "system/contact.hpp"
#include "system/ease.hpp"
#include "voile/errors.hpp"

namespace voile::record {

namespace {

using Kind = input::Probe::Kind;

constexpr std::array<const char*, 3> axis{"x", "y", "z"};
constexpr std::array<const char*, 3> pair{"11", "22", "12"};  ///< of a stress
constexpr int up = 2;                                         ///< unless a probe of height says otherwise

Index nearest_vertex(const mesh::SurfaceMesh& mesh, const Vec3& point) {
  Index best = 0;
  for (Index v = 1; v < mesh.vertex_count(); ++v)
    if ((mesh.positions()[v] - point).squaredNorm() < (mesh.positions()[best] - point).squaredNorm()) best = v;
  return best;
}

std::vector<Index> vertices_of(const input::Probe& probe, const mesh::SurfaceMesh& mesh) {
  const std::string named = "probe " + probe.name;  // where the vertex has to outlive its mesh
  if (probe.point && mesh.has_group(named)) return mesh.group(named).vertices;
  if (probe.point) return {nearest_vertex(mesh, *probe.point)};
  return probe.group.empty() ? std::vector<Index>{} : mesh.group(probe.group).vertices;
}

/// In a mean.
std::vector<double> weights_of(const input::Probe& probe, const std::vector<Index>& vertices,
                               const mesh::SurfaceMesh& mesh) {
  if (!probe.point && !probe.group.empty()) return mesh::group_weights(mesh, mesh.group(probe.group));
  return std::vector<double>(vertices.size(), 1.0 / static_cast<double>(vertices.size()));
}

/// Parts of the columns' names after that of the probe.
std::vector<std::string> parts_of(Kind kind, const std::vector<int>& components) {
  if (kind == Kind::stress) return {pair[0], pair[1], pair[2], "von_mises"};
  if (kind == Kind::energy) return {"membrane", "bending", "external"};
  if (kind == Kind::ease) return {"min", "mean"};
  if (kind == Kind::height) return {"min", "mean", "max"};
  std::vector<std::string> parts;
  for (const int k : components) parts.emplace_back(axis[static_cast<std::size_t>(k)]);
  return parts;
}

/// Of a stage that does not have the obstacle nothing is known.
std::vector<double> force_on(const std::string& obstacle, const std::vector<int>& components,
                             const std::vector<Vec3>& forces, const system::Contact* contact) {
  std::vector<double> own(components.size(), std::nan(""));
  for (std::size_t k = 0; k < forces.size(); ++k)
    if (contact->scene().input().obstacles[k].name == obstacle)
      std::transform(components.begin(), components.end(), own.begin(), [&](int i) { return forces[k][i]; });
  return own;
}

/// Least, mean and largest height of the sheet, where `heights` are those of vertices that count as much as `weights`.
std::vector<double> range_of(const std::vector<double>& heights, const std::vector<double>& weights) {
  double mean = 0.0;
  for (std::size_t v = 0; v < heights.size(); ++v) mean += weights[v] * heights[v];
  const auto [least, largest] = std::minmax_element(heights.begin(), heights.end());
  return {*least, mean, *largest};
}

}  // namespace

std::vector<std::string> probe_warnings(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  std::vector<std::string> texts;
  for (const input::Probe& probe : c.probes) {
    if (!probe.point || mesh.has_group("probe " + probe.name)) continue;
    const Index v = nearest_vertex(mesh, *probe.point);
    const Vec3& x = mesh.positions()[v];
    double longest = 0.0;
    for (const Index t : mesh.triangles_of_vertex(v))
      for (const Index w : mesh.triangles()[t]) longest = std::max(longest, (mesh.positions()[w] - x).norm());
    const Vec3& p = *probe.point;
    if (const double away = (p - x).norm(); away > longest)
      texts.push_back(
          fmt::format("probe '{}' at ({:.4g}, {:.4g}, {:.4g}) m is {:.3g} m away from the sheet: it measures the "
                      "nearest vertex, at "
                      "({:.4g}, {:.4g}, {:.4g}) m; correct its `point`",
                      probe.name, p[0], p[1], p[2], away, x[0], x[1], x[2]));
  }
  return texts;
}

namespace {

/// The triangle whose stress a probe observes.
Index stressed_triangle(const input::Case& c, const input::Probe& probe, const system::Model& model) {
  if (c.remesh.active || !c.panels.empty())
    throw UserError(fmt::format(
        "{}: [[probe]] '{}' type = \"stress\": a new mesh does not have the triangle whose stress this is; write "
        "output.stresses, or remove [remesh] or the panels",
        c.file.string(), probe.name));
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  const Index t = geometry::ClosestTriangle(mesh.positions(), mesh.triangles()).find(*probe.point);
  if (model.discretisation().sheet().material(t).layers.empty())
    throw UserError(fmt::format(
        "{}: [[probe]] '{}' type = \"stress\": the material there is given by stiffnesses, without its layers; give it "
        "young and thickness or plies, or observe fields of force instead",
        c.file.string(), probe.name));
  return t;
}

}  // namespace

Probes::Probes(const input::Case& c, const system::Model& model) : case_(c) {
  for (const input::Probe& probe : c.probes) {
    const mesh::SurfaceMesh& mesh = model.dofs().mesh();
    Members m{vertices_of(probe, mesh), probe.components, {}};
    m.weights = weights_of(probe, m.vertices, mesh);
    if (m.components.empty())
      m.components = probe.kind == Kind::height ? std::vector<int>{up} : std::vector<int>{0, 1, 2};
    if (probe.kind == Kind::ease && !(model.contact() && system::has_bodies(model.contact()->scene().input())))
      throw UserError(
          fmt::format("{}: [[probe]] '{}' type = \"ease\": there is no body to be near to; give the case "
                      "an [[obstacle]] that is no half-space{}",
                      c.file.string(), probe.name, c.is_staged() ? ", in every stage" : ""));
    if (probe.kind == Kind::reaction && model.discretisation().is_on_body(m.vertices))
      throw UserError(fmt::format(
          "{}: [[probe]] '{}' type = \"reaction\": vertices of '{}' belong to a [[rigid]] group, whose forces "
          "act at its reference point; remove the probe and read the group's columns: {}_force_x and so on",
          c.file.string(), probe.name, probe.group, c.rigids.front().name));
    if (probe.kind == Kind::stress) m.triangle = stressed_triangle(c, probe, model);
    members_.push_back(std::move(m));
  }
}

bool Probes::any(Kind kind) const {
  return std::any_of(case_.probes.begin(), case_.probes.end(), [&](const input::Probe& p) { return p.kind == kind; });
}

std::vector<std::string> Probes::columns() const {
  std::vector<std::string> names;
  for (std::size_t p = 0; p < members_.size(); ++p)
    for (const std::string& part : parts_of(case_.probes[p].kind, members_[p].components))
      names.push_back(fmt::format("{}_{}", case_.probes[p].name, part));
  return names;
}

std::vector<double> Probes::components_of(const input::Probe& probe, const Members& m, const Observed& state) const {
  const bool is_mean = probe.kind == Kind::displacement;
  const std::vector<double>& field = is_mean ? state.displacement : state.reaction;
  std::vector<double> values;
  for (const int k : m.components) {
    double sum = 0.0;
    for (std::size_t v = 0; v < m.vertices.size(); ++v)
      sum += (is_mean ? m.weights[v] : 1.0) *
             field[3 * static_cast<std::size_t>(m.vertices[v]) + static_cast<std::size_t>(k)];
    values.push_back(sum);
  }
  return values;
}

std::vector<double> Probes::heights(const Members& m, const std::vector<double>& displacement,
                                    const mesh::SurfaceMesh& mesh, double ground) {
  const auto k = m.components.front();
  std::vector<double> all;
  for (const Index v : m.vertices)
    all.push_back(mesh.positions()[v][k] + displacement[3 * static_cast<std::size_t>(v) + static_cast<std::size_t>(k)] -
                  ground);
  return all;
}

std::vector<double> Probes::values(const Observed& state, const system::Model& model) const {
  std::vector<double> all;
  std::size_t stress = 0;
  for (std::size_t p = 0; p < members_.size(); ++p) {
    const input::Probe& probe = case_.probes[p];
    const Members& m = members_[p];
    std::vector<double> own;
    if (probe.kind == Kind::energy) {
      own = {state.energies.membrane, state.energies.bending, state.energies.external};
    } else if (probe.kind == Kind::ease) {
      const system::EaseRange range = system::range_of_ease(model.contact()->scene(), state.ease, m.vertices);
      own = {range.least, range.mean};
    } else if (probe.kind == Kind::stress) {
      const Vec3& s = state.stresses[stress++];
      own = {s[0], s[1], s[2], von_mises(s)};
    } else if (probe.kind == Kind::contact) {
      own = force_on(probe.obstacle, m.components, state.on_obstacles, model.contact());
    } else if (probe.kind == Kind::height) {
      own = range_of(heights(m, state.displacement, model.dofs().mesh(), probe.ground), m.weights);
    } else {
      own = components_of(probe, m, state);
    }
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

std::vector<Vec3> Probes::stresses(const system::Model& model, const system::TriangleFields& fields) const {
  std::vector<Vec3> all;
  for (std::size_t p = 0; p < members_.size(); ++p)
    if (case_.probes[p].kind == Kind::stress)
      all.push_back(face_stress(model.discretisation().sheet(), fields, members_[p].triangle,
                                case_.probes[p].face == input::Probe::Face::top));
  return all;
}

std::vector<Probes::Component> Probes::vibrating() const {
  std::vector<Component> all;
  for (std::size_t p = 0; p < members_.size(); ++p) {
    const input::Probe& probe = case_.probes[p];
    if (probe.kind == Kind::displacement || probe.kind == Kind::reaction)
      for (const int k : members_[p].components)
        all.push_back({fmt::format("{}_{}", probe.name, axis[static_cast<std::size_t>(k)]), probe.kind, p, k});
    for (std::size_t k = 0; probe.kind == Kind::stress && k < pair.size(); ++k)
      all.push_back({fmt::format("{}_{}", probe.name, pair[k]), probe.kind, p, static_cast<int>(k)});
  }
  return all;
}

std::vector<double> Probes::vibrating_values(const Observed& change) const {
  std::vector<double> all;
  std::size_t stress = 0;
  for (std::size_t p = 0; p < members_.size(); ++p) {
    const Kind kind = case_.probes[p].kind;
    if (kind == Kind::stress) {
      const Vec3& s = change.stresses[stress++];
      all.insert(all.end(), s.begin(), s.end());
    }
    if (kind != Kind::displacement && kind != Kind::reaction) continue;
    const std::vector<double> own = components_of(case_.probes[p], members_[p], change);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

petsc::VecHandle Probes::functional(const std::string& name, const system::Model& model) const {
  petsc::VecHandle c = model.dofs().create_vector();
  for (std::size_t p = 0; p < members_.size(); ++p) {
    if (case_.probes[p].name != name) continue;
    std::vector<double> values(static_cast<std::size_t>(model.dofs().unknowns()), 0.0);
    const Members& m = members_[p];
    for (std::size_t v = 0; v < m.vertices.size(); ++v)
      values[3 * static_cast<std::size_t>(m.vertices[v]) + static_cast<std::size_t>(m.components.front())] +=
          m.weights[v];
    model.dofs().scatter(values, c);
  }
  return c;
}

}  // namespace voile::record

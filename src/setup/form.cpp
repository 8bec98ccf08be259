#include "form.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/unions.hpp"
#include "energy/sheet.hpp"
#include "form_finding.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

using Kind = system::Support::Kind;

[[noreturn]] void fail(const input::Case& c, const std::string& what) {
  throw UserError(fmt::format("{}: [form]: {}", c.file.string(), what));
}

std::array<bool, 3> held_by(const system::Support& s) {
  if (s.kind == Kind::clamped || s.kind == Kind::hinged) return {true, true, true};
  if (s.kind != Kind::symmetry) return s.components;
  std::array<bool, 3> held{};
  Eigen::Index axis = 0;
  s.normal->cwiseAbs().maxCoeff(&axis);
  held[static_cast<std::size_t>(axis)] = true;
  return held;
}

std::vector<std::array<bool, 3>> held_in(const input::Case& first, const mesh::SurfaceMesh& mesh) {
  std::vector<std::array<bool, 3>> held(static_cast<std::size_t>(mesh.vertex_count()), {false, false, false});
  for (const system::Support& s : first.supports)
    for (const Index v : mesh.group(s.group).vertices)
      for (std::size_t k = 0; k < 3; ++k) {
        bool& here = held[static_cast<std::size_t>(v)][k];
        here = here || held_by(s)[k];
      }
  return held;
}

/// Throws unless every connected piece has a vertex that is held in x, one in y and one in z.
void require_held(const input::Case& c, const mesh::SurfaceMesh& mesh, const std::vector<std::array<bool, 3>>& held) {
  Unions connected(held.size());
  for (const mesh::Triangle& t : mesh.triangles())
    for (const Index v : t) connected.join(v, t[0]);
  std::vector<std::array<bool, 3>> piece(held.size(), {false, false, false});
  for (std::size_t v = 0; v < held.size(); ++v)
    for (std::size_t k = 0; k < 3; ++k)
      if (held[v][k]) piece[static_cast<std::size_t>(connected.find(static_cast<Index>(v)))][k] = true;
  for (std::size_t v = 0; v < held.size(); ++v)
    for (std::size_t k = 0; k < 3; ++k)
      if (!piece[static_cast<std::size_t>(connected.find(static_cast<Index>(v)))][k]) {
        const Vec3& x = mesh.positions()[v];
        fail(c, fmt::format("nothing holds the piece at ({:g}, {:g}, {:g}) m along {}; add a [[support]]", x[0], x[1],
                            x[2], "xyz"[k]));
      }
}

/// In global axes, of a triangle of this normal. Throws UserError where the direction is normal to it.
Mat3 force_of(const input::Case& c, const energy::Material& m, const Vec3& normal, const Vec3& corner) {
  const Vec3& n = m.prestress;
  if (n[0] == n[1] && n[2] == 0.0) return n[0] * (Mat3::Identity() - normal * normal.transpose());
  constexpr double least = 0.05;  // sine of 3 degrees
  const Vec3 along = m.direction->normalized() - normal.dot(m.direction->normalized()) * normal;
  if (along.norm() < least)
    fail(c, fmt::format(
                "the `direction` of a [[material]] is normal to the surface at ({:g}, {:g}, {:g}) m; give one along "
                "it, or two equal forces as prestress",
                corner[0], corner[1], corner[2]));
  const Vec3 e1 = along.normalized(), e2 = normal.cross(e1);
  return n[0] * e1 * e1.transpose() + n[1] * e2 * e2.transpose() + n[2] * (e1 * e2.transpose() + e2 * e1.transpose());
}

/// Rank 0 only.
FormResult found(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  const input::Case& first = c.stages.empty() ? c : c.stages.front();
  FormProblem p;
  p.places = mesh.positions();
  p.triangles = mesh.triangles();
  p.held = held_in(first, mesh);
  require_held(c, mesh, p.held);
  for (const system::Spring& s : first.springs)
    if (s.kind == system::Spring::Kind::band && s.force > 0.0)
      for (const mesh::Segment& edge : mesh.group(s.group, 1).segments) p.cables.push_back({edge, s.force});
  const std::vector<int> material_of = energy::assign_materials(mesh, first.materials);
  bool isotropic = true;
  for (const energy::Material& m : first.materials)
    isotropic = isotropic && m.prestress == first.materials.front().prestress && m.prestress[0] == m.prestress[1] &&
                m.prestress[2] == 0.0;
  if (isotropic) p.within = largest_within;
  p.force = [&](Index t, const std::array<Vec3, 3>& x) {
    const Vec3 normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    return force_of(c, first.materials[static_cast<std::size_t>(material_of[static_cast<std::size_t>(t)])], normal,
                    x[0]);
  };
  p.pressure = c.form.pressure;
  FormResult r = find_form(p);
  if (r.converged) return r;
  std::string where;
  if (r.collapsed != no_index) {
    const Vec3& x = r.places[static_cast<std::size_t>(mesh.triangles()[static_cast<std::size_t>(r.collapsed)][0])];
    where = fmt::format(", where it contracts to nothing at ({:.4g}, {:.4g}, {:.4g}) m", x[0], x[1], x[2]);
  }
  fail(c, fmt::format("no equilibrium of the prestress is found after {} steps{}; bring the supports closer together, "
                      "change prestress, cables (`force` of a band) or `pressure`, or draw a start that is closer to "
                      "the form and has fewer, "
                      "even cells",
                      r.iterations, where));
}

}  // namespace

mesh::SurfaceMesh with_form(MPI_Comm comm, const input::Case& c, mesh::SurfaceMesh mesh) {
  if (!c.form.active) return mesh;
  std::vector<double> places, said;
  mpi::on_root(comm, [&] {
    const FormResult r = found(c, mesh);
    said = {static_cast<double>(r.iterations), r.within};
    for (const Vec3& x : r.places) places.insert(places.end(), x.begin(), x.end());
  });
  mpi::broadcast(comm, places);
  mpi::broadcast(comm, said);
  mesh::MeshData data = mesh.data();
  double most = 0.0;
  for (std::size_t v = 0; v < data.positions.size(); ++v) {
    const Vec3 x = Eigen::Map<const Vec3>(&places[3 * v]);
    most = std::max(most, (x - data.positions[v]).norm());
    data.positions[v] = x;
  }
  data.notes.push_back(
      fmt::format("the form was found in {:g} steps, up to {:.4g} m from the mesh; forces within it are "
                  "out of balance by {:.1e} of those at a vertex, which changes the tension of a stiff sheet",
                  said[0], most, said[1]));
  return mesh::SurfaceMesh(std::move(data));
}

}  // namespace voile::setup

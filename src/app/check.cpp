// Reports on a case or a mesh without solving.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "obstacles.hpp"
#include "voile/app/run.hpp"
#include "voile/base/mpi.hpp"
#include "voile/base/petsc.hpp"
#include "voile/energy/curvature.hpp"
#include "voile/system/dynamics.hpp"
#include "voile/system/model.hpp"

namespace voile::app {

namespace {

double smallest_angle(const mesh::SurfaceMesh& mesh, Index t) {
  double smallest = std::numbers::pi;
  for (int i = 0; i < 3; ++i) {
    const Vec3 a = mesh.corner(t, (i + 1) % 3) - mesh.corner(t, i), b = mesh.corner(t, (i + 2) % 3) - mesh.corner(t, i);
    smallest = std::min(smallest, std::acos(std::clamp(a.dot(b) / (a.norm() * b.norm()), -1.0, 1.0)));
  }
  return smallest * 180.0 / std::numbers::pi;
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

void print_groups(const mesh::SurfaceMesh& mesh) {
  static constexpr std::array<const char*, 3> kinds{"point", "curve", "surface"};
  for (const mesh::Group& g : mesh.groups())
    fmt::print("  {:<8} '{}': {} vertices, {} edges, {} triangles\n", kinds[static_cast<std::size_t>(g.dimension)],
               g.name, g.vertices.size(), g.segments.size(), g.triangles.size());
}

void print_quality(const mesh::SurfaceMesh& mesh) {
  std::vector<double> angle, edge;
  Index boundary = 0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) {
    angle.push_back(smallest_angle(mesh, t));
    for (int s = 0; s < 3; ++s) {
      edge.push_back((mesh.corner(t, (s + 1) % 3) - mesh.corner(t, (s + 2) % 3)).norm());
      boundary += mesh.neighbour(t, s) == no_index ? 1 : 0;
    }
  }
  fmt::print("edges: {:.4g} .. {:.4g} m, median {:.4g} m; {} on the boundary\n", quantile(edge, 0.0),
             quantile(edge, 1.0), quantile(edge, 0.5), boundary);
  fmt::print("smallest angle of a triangle: {:.1f} deg at worst, {:.1f} deg median\n", quantile(angle, 0.0),
             quantile(angle, 0.5));
}

/// Interior vertices of valence 4 and 8 in large numbers mark a union-jack pattern, on which `six_node` is wrong.
double union_jack_share(const mesh::SurfaceMesh& mesh) {
  Index suspicious = 0, interior = 0;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const std::vector<Index> around = mesh.triangles_of_vertex(v);
    const bool inside = std::all_of(around.begin(), around.end(), [&](Index t) {
      for (int s = 0; s < 3; ++s)
        if (mesh.neighbour(t, s) == no_index && mesh.triangles()[t][s] != v) return false;
      return true;
    });
    if (!inside) continue;
    ++interior;
    suspicious += around.size() == 4 || around.size() == 8 ? 1 : 0;
  }
  return interior ? static_cast<double>(suspicious) / interior : 0.0;
}

void print_patches(const mesh::SurfaceMesh& mesh, const energy::ElementOptions& element) {
  energy::Material unit;
  unit.membrane = energy::isotropic_membrane(1.0, 0.3, 1.0);
  unit.bending = energy::bending_from_membrane(unit.membrane, 1.0);
  const std::vector<energy::Material> materials{unit};
  const mesh::PatchMesh patches(mesh, {});
  const energy::Sheet sheet(patches, materials, energy::assign_materials(mesh, materials), element);
  energy::CurvatureBuilder builder(sheet);
  std::vector<double> condition;
  for (Index t = 0; t < mesh.triangle_count(); ++t) condition.push_back(builder.patch_condition(t));
  const auto bad =
      std::count_if(condition.begin(), condition.end(), [&](double c) { return !(c <= element.max_patch_condition); });
  fmt::print("patch condition: {:.3g} median, {:.3g} at 99 %, {:.3g} at worst; {} patches above {} ({:.2f} %)\n",
             quantile(condition, 0.5), quantile(condition, 0.99), quantile(condition, 1.0), bad,
             element.max_patch_condition, 100.0 * static_cast<double>(bad) / static_cast<double>(condition.size()));
}

void print_balance(const mesh::SurfaceMesh& mesh, int ranks) {
  const std::vector<int> part = mesh::divide_vertices(mesh, ranks);
  std::vector<Index> count(static_cast<std::size_t>(ranks), 0);
  for (int p : part) ++count[p];
  Index cut = 0;
  for (const mesh::Triangle& t : mesh.triangles()) cut += part[t[0]] != part[t[1]] || part[t[1]] != part[t[2]] ? 1 : 0;
  const auto [low, high] = std::minmax_element(count.begin(), count.end());
  fmt::print("partition over {} rank(s): {} .. {} vertices per rank, {} triangles on the cut\n", ranks, *low, *high,
             cut);
}

void report(const mesh::SurfaceMesh& mesh, const energy::ElementOptions& element) {
  fmt::print("{}: {} vertices, {} triangles, {} unknowns, {} connected piece(s)\n", mesh.source(), mesh.vertex_count(),
             mesh.triangle_count(), 3 * mesh.vertex_count(), mesh.component_count());
  if (mesh.reoriented_count() > 0)
    fmt::print("{} triangles were turned round to orient the surface\n", mesh.reoriented_count());
  fmt::print("groups:\n");
  print_groups(mesh);
  print_quality(mesh);
  print_patches(mesh, element);
  print_balance(mesh, mpi::size(PETSC_COMM_WORLD));
  print_warnings(mesh, element);
}

}  // namespace

void print_warnings(const mesh::SurfaceMesh& mesh, const energy::ElementOptions& element) {
  if (element.bending != energy::BendingOperator::six_node) return;
  const double share = union_jack_share(mesh);
  if (share > 0.5)
    fmt::print(
        "warning: {:.0f} % of the interior vertices have valence 4 or 8 (alternating diagonals): bending = "
        "\"six_node\" does not converge on such a mesh, use \"edge_slope\"\n",
        100.0 * share);
}

void info(const mesh::SurfaceMesh& mesh, const energy::ElementOptions& element) {
  mpi::on_root(PETSC_COMM_WORLD, [&] { report(mesh, element); });
}

void check(const Case& c) {
  const mesh::SurfaceMesh mesh = load_mesh(c.mesh.file, c.mesh.options);
  const system::Model model(PETSC_COMM_WORLD, mesh,
                            {c.element, c.materials, c.supports, c.loads, contact_input(PETSC_COMM_WORLD, c)});
  if (c.analysis == "modal" || c.analysis == "dynamic") system::require_mass(model);
  mpi::on_root(PETSC_COMM_WORLD, [&] {
    for (const Probe& p : c.probes)
      if (!p.group.empty()) (void)mesh.group(p.group);
    report(mesh, c.element);
    std::size_t fixed = 0;
    for (const auto& [v, support] : model.constraints().vertices)
      fixed += static_cast<std::size_t>(std::count(support.fixed.begin(), support.fixed.end(), true));
    fmt::print("{} fixed components, {} mirrored edges, {} load(s), tangent {}\n", fixed,
               model.constraints().mirrors.size(), c.loads.size(), model.symmetric() ? "symmetric" : "unsymmetric");
    fmt::print("{}: no errors found\n", c.file.string());
  });
}

}  // namespace voile::app

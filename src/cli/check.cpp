#include "check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/mpi.hpp"
#include "base/petsc.hpp"
#include "mesh/border.hpp"
#include "record/probes.hpp"
#include "record/report.hpp"
#include "record/validity.hpp"
#include "remesh/remesher.hpp"
#include "setup/free_motions.hpp"
#include "setup/garment.hpp"
#include "setup/gas_rims.hpp"
#include "setup/group_names.hpp"
#include "setup/hinge_notes.hpp"
#include "setup/mesh_report.hpp"
#include "setup/start_supports.hpp"
#include "simulation/contact_start.hpp"
#include "simulation/excitation.hpp"
#include "simulation/restart.hpp"
#include "simulation/sewing.hpp"
#include "simulation/stage_check.hpp"
#include "simulation/stages.hpp"
#include "system/dynamics.hpp"
#include "system/model.hpp"

namespace voile::cli {

namespace {

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

void print_edges(const mesh::SurfaceMesh& mesh) {
  std::vector<double> edge;
  Index boundary = 0, parted = 0, joined = 0;
  for (const mesh::Joint& j : mesh.joints()) {
    parted += static_cast<Index>(j.sides.size());
    joined += mesh::is_clamped_border(mesh, j) ? 0 : 1;
  }
  for (Index t = 0; t < mesh.triangle_count(); ++t)
    for (int s = 0; s < 3; ++s) {
      edge.push_back((mesh.rest_corner(t, (s + 1) % 3) - mesh.rest_corner(t, (s + 2) % 3)).norm());
      boundary += mesh.neighbour(t, s) == no_index ? 1 : 0;
    }
  fmt::print("edges: {:.4g} .. {:.4g} m, median {:.4g} m; {} on the boundary{}\n", quantile(edge, 0.0),
             quantile(edge, 1.0), quantile(edge, 0.5), boundary - parted,
             joined == 0 ? "" : fmt::format(", {} at joints of sheets", joined));
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

void report(const mesh::SurfaceMesh& mesh, int ranks, const setup::MeshQuality& quality,
            const energy::ElementOptions& element, setup::Crossings crossings) {
  fmt::print("{}: {} vertices, {} triangles, {} unknowns, {} connected piece{}\n", mesh.source(), mesh.vertex_count(),
             mesh.triangle_count(), 3 * mesh.vertex_count(), mesh.component_count(),
             mesh.component_count() == 1 ? "" : "s");
  if (mesh.reoriented_count() > 0)
    fmt::print("{} triangles were turned round to orient the surface\n", mesh.reoriented_count());
  fmt::print("groups:\n");
  print_groups(mesh);
  print_edges(mesh);
  print_balance(mesh, ranks);
  fmt::print("{}", setup::quality_text(mesh, quality, element));
  for (const std::string& text : setup::mesh_notes(mesh, crossings)) fmt::print("note: {}\n", text);
  for (const std::string& text : setup::quality_warnings(mesh, quality, element)) fmt::print("warning: {}\n", text);
  if (const std::string text = setup::fold_warning(mesh, quality, element); !text.empty())
    fmt::print("warning: {}\n", text);
}

}  // namespace

void info(MPI_Comm comm, const mesh::SurfaceMesh& mesh, const energy::ElementOptions& element) {
  const setup::MeshQuality quality = setup::measure_quality(comm, mesh, element);
  mpi::on_root(comm, [&] { report(mesh, mpi::size(comm), quality, element, setup::Crossings::noted); });
}

void check(MPI_Comm comm, const input::Case& whole) {
  const std::string garment = setup::garment_report(comm, whole);
  const auto given = std::make_shared<const mesh::SurfaceMesh>(setup::case_mesh(comm, whole));
  setup::check_group_names(whole, *given);
  const mesh::SurfaceMesh& mesh = *given;
  const std::vector<simulation::Stage> stages = simulation::stages_of(whole, {comm});
  const auto meshes = simulation::stage_meshes(stages, given);
  for (std::size_t k = 1; k < stages.size(); ++k) simulation::check_stage(stages[k], *meshes[k]);
  const input::Case& c = stages.front().c;
  system::Model model(comm, mesh, stages.front().input);
  if (c.vibrates() || c.analysis == input::Analysis::dynamic) system::require_mass(model);
  std::vector<std::string> free = setup::check_free_motions(c, model);
  for (std::string& text : setup::moving_rims(c, model)) free.push_back(std::move(text));
  simulation::require_excitation(c, model);
  simulation::require_growth(c, model);
  setup::MeshQuality quality = setup::measure_quality(comm, mesh, c.element);
  quality.large_rotations = setup::is_nonlinear(whole);
  const std::string uncorrected = setup::uncorrected_text(model.potential().uncorrected_triangles());
  const petsc::VecHandle start = model.dofs().create_vector();
  if (!c.mesh.start.empty()) model.dofs().scatter(simulation::start_shape(comm, c, mesh), start);
  setup::check_start_supports(c, model, start);
  const system::TriangleFields at_rest = model.triangle_fields(start);
  remesh::check_remesh(comm, c, mesh);
  std::string outlook;
  if (c.remesh.active) {
    const auto first = std::make_shared<const mesh::SurfaceMesh>(mesh.data());
    results::Checkpoint at_start;
    at_start.displacement = simulation::start_shape(comm, c, mesh);
    remesh::Epoch epoch(comm, c, *first, stages.front().input, stages.front().frozen, at_start);
    outlook = remesh::remesh_outlook(stages.front(), first, epoch);
  }
  if (model.contact()) simulation::examine_start(c, *model.contact(), start);
  mpi::on_root(comm, [&] {
    (void)record::Probes(c, model);
    fmt::print("{}", record::units_text(c));
    report(mesh, mpi::size(comm), quality, c.element,
           c.contact.input.active ? setup::Crossings::seen : setup::Crossings::noted);
    if (const std::string text = record::locking_warning(model.discretisation().sheet(), at_rest); !text.empty())
      fmt::print("warning: {}\n", text);
    if (!uncorrected.empty()) fmt::print("warning: {}\n", uncorrected);
    for (const std::string& text : record::probe_warnings(c, mesh)) fmt::print("warning: {}\n", text);
    if (const std::string text = setup::unit_warning(c, mesh); !text.empty()) fmt::print("warning: {}\n", text);
    fmt::print("{}", garment);
    std::size_t fixed = 0;
    for (const auto& [v, support] : model.discretisation().constraints().vertices)
      fixed += static_cast<std::size_t>(std::count(support.fixed.begin(), support.fixed.end(), true));
    fmt::print("{} fixed components, {} mirrored edges, {} load(s), tangent {}\n", fixed,
               model.discretisation().constraints().mirrors.size(), c.loads.size(),
               model.conditions().symmetric() ? "symmetric" : "unsymmetric");
    for (const std::string& text : setup::hinge_warnings(c, mesh)) fmt::print("warning: {}\n", text);
    for (const std::string& text : c.notes) fmt::print("note: {}\n", text);
    for (const std::string& text : setup::sheet_notes(model.discretisation().sheet())) fmt::print("note: {}\n", text);
    for (const std::string& text : free) fmt::print("note: {}\n", text);
    if (!outlook.empty()) fmt::print("{}\n", outlook);
    for (const simulation::Stage& stage : stages)
      if (stage.c.is_staged()) fmt::print("stage '{}': {}\n", stage.c.stage.name, input::word_of(stage.c.analysis));
    fmt::print("{}: no errors found\n", c.file.string());
  });
}

}  // namespace voile::cli

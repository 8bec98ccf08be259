#include "membrane_choice.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <utility>
#include <vector>

#include "voile/base/error.hpp"
#include "voile/base/mpi.hpp"
#include "voile/base/petsc.hpp"
#include "voile/energy/chord_error.hpp"
#include "voile/energy/curvature.hpp"
#include "voile/mesh/patch.hpp"

namespace voile::app {

namespace {

using energy::MembraneOperator;

/// Share of the deflection that six_node may err by.
constexpr double limit = 0.01;
/// Share from which on a case that has chosen six_node is told.
constexpr double told = 0.05;

/// kappa0 of all triangles, on rank 0. Collective.
std::vector<double> rest_curvature(MPI_Comm comm, const energy::Sheet& sheet) {
  const auto n = static_cast<std::size_t>(sheet.mesh().triangle_count());
  std::vector<double> own;
  mpi::on_all(comm, [&] {
    energy::CurvatureBuilder builder(sheet);
    const auto rank = static_cast<std::size_t>(mpi::rank(comm)), ranks = static_cast<std::size_t>(mpi::size(comm));
    for (std::size_t t = n * rank / ranks; t < n * (rank + 1) / ranks; ++t) {
      const auto triangle = static_cast<Index>(t);
      const Vec3 k = builder.build(triangle).rest * sheet.frame(triangle).normal;
      own.insert(own.end(), k.begin(), k.end());
    }
  });
  return mpi::gather_to_root(comm, own);
}

/// Whether all stages look for equilibria under large rotations, none for the folds of something that falls or moves.
bool only_static(const input::Case& c) {
  const auto is_static = [](const input::Case& one) { return one.analysis == "static"; };
  return c.stages.empty() ? is_static(c) : std::all_of(c.stages.begin(), c.stages.end(), is_static);
}

MembraneChoice decide(const input::Case& c, const energy::Sheet& sheet, const std::vector<double>& rest) {
  const double curved = energy::locking_estimate(sheet, rest);
  const energy::RolledUp flat = only_static(c) ? energy::rolled_up(sheet) : energy::RolledUp{};
  const bool corrected = std::max({curved, flat.stiffer, flat.softer}) > limit;
  const MembraneOperator chosen = corrected ? MembraneOperator::six_node_corrected : MembraneOperator::six_node;
  std::string text = fmt::format(
      "membrane: {}, chosen by \"auto\": six_node is expected to err by {:.2g} % in bending a "
      "shell of this curvature and thickness",
      name(chosen), 100.0 * curved);
  if (only_static(c))
    text += fmt::format(", if rolled up by {:.2g} % for uneven cells and {:.2g} % for long ones", 100.0 * flat.stiffer,
                        100.0 * flat.softer);
  return {chosen, text + fmt::format(" (limit {:g} %)", 100.0 * limit)};
}

/// What six_node could do to a static case that has it, or nothing. On one rank.
std::string outlook(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  const mesh::PatchMesh patches(mesh, {});
  const energy::Sheet sheet(patches, c.materials, energy::assign_materials(mesh, c.materials), c.element);
  const energy::RolledUp flat = energy::rolled_up(sheet);
  if (!(std::max(flat.stiffer, flat.softer) > told)) return "";
  return fmt::format(
      "note: membrane: if the sheet bent as far as a roll over its extent, six_node would be expected to err by {:.2g} "
      "% "
      "for uneven cells and {:.2g} % for long ones (limit {:g} %); finer or more even cells, or "
      "element.membrane = \"auto\"",
      100.0 * flat.stiffer, 100.0 * flat.softer, 100.0 * told);
}

}  // namespace

const char* name(MembraneOperator membrane) {
  switch (membrane) {
    case MembraneOperator::cst:
      return "cst";
    case MembraneOperator::six_node:
      return "six_node";
    case MembraneOperator::six_node_corrected:
      return "six_node_corrected";
    case MembraneOperator::six_node_three_point:
      return "six_node_three_point";
    case MembraneOperator::automatic:
      break;
  }
  return "auto";
}

MembraneChoice choose_membrane(MPI_Comm comm, const input::Case& c, const mesh::SurfaceMesh& mesh) {
  if (c.element.membrane != MembraneOperator::automatic) {
    std::string text;
    if (c.element.membrane == MembraneOperator::six_node && only_static(c))
      mpi::on_root(comm, [&] { text = outlook(c, mesh); });
    return {c.element.membrane, text};
  }
  const mesh::PatchMesh patches(mesh, {});
  const energy::Sheet sheet(patches, c.materials, energy::assign_materials(mesh, c.materials), c.element);
  const std::vector<double> rest = rest_curvature(comm, sheet);
  MembraneChoice choice{MembraneOperator::six_node, ""};
  mpi::on_root(comm, [&] { choice = decide(c, sheet, rest); });
  std::vector<Index> chosen{static_cast<Index>(choice.membrane)};
  mpi::broadcast(comm, chosen);
  choice.membrane = static_cast<MembraneOperator>(chosen.front());
  return choice;
}

input::Case with_membrane(input::Case c, MembraneOperator membrane) {
  c.element.membrane = membrane;
  for (input::Case& stage : c.stages) stage.element.membrane = membrane;
  return c;
}

}  // namespace voile::app

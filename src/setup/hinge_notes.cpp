#include "hinge_notes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "system/hinges.hpp"

namespace voile::setup {

namespace {

/// Vertices that a section of the case holds in some direction.
std::vector<char> held_vertices(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  std::vector<char> held(static_cast<std::size_t>(mesh.vertex_count()), 0);
  const auto hold = [&](const std::string& group) {
    if (group.empty() || !mesh.has_group(group)) return;
    for (const Index v : mesh.group(group).vertices) held[static_cast<std::size_t>(v)] = 1;
  };
  for (const system::Support& s : c.supports) hold(s.group);
  for (const input::RigidSection& s : c.rigids) hold(s.group.group);
  for (const system::Spring& s : c.springs) hold(s.group);
  for (const system::Attachment& s : c.attachments)
    for (const std::string& group : s.groups) hold(group);
  return held;
}

/// A hinge folds with forces of k/h, where cells of size h over an extent L have round-off of A eps L/h, and more of it the more of them
/// lie one behind another: measured, folds are found from k = 0.01 eps A L (L/h)^3 on.
double least_stiffness(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  constexpr double factor = 0.02;
  double stretching = 0.0;
  for (const energy::Material& m : c.materials) stretching = std::max(stretching, m.membrane.cwiseAbs().maxCoeff());
  double area = 0.0;
  for (Index t = 0; t < mesh.triangle_count(); ++t) area += mesh.area(t);
  const double cell = std::sqrt(area / mesh.triangle_count());
  return factor * std::numeric_limits<double>::epsilon() * stretching * mesh.extent() *
         std::pow(mesh.extent() / cell, 3);
}

}  // namespace

std::vector<std::string> hinge_warnings(const input::Case& c, const mesh::SurfaceMesh& mesh) {
  std::vector<std::string> warnings;
  if (c.hinges.empty()) return warnings;
  const std::vector<char> held = held_vertices(c, mesh);
  const double least = least_stiffness(c, mesh);
  for (const system::Hinge& hinge : c.hinges) {
    if (hinge.angle.value && hinge.stiffness < least)
      warnings.push_back(fmt::format(
          "[[hinge]] group '{}': stiffness = {:.3g} N: what it folds with is lost in the round-off of a sheet that is "
          "this stiff, and no equilibrium may be found; give {:.1g} N or more, or larger cells",
          hinge.group, hinge.stiffness, least));
    int count = 0;
    Vec3 place = Vec3::Zero();
    for (const system::HingeEdge& e : system::edges_of(mesh, hinge)) {
      const auto is_held = [&](Index v) { return held[static_cast<std::size_t>(v)] != 0; };
      if (!system::on_boundary(mesh, e.number) || is_held(e.edge[0]) || is_held(e.edge[1])) continue;
      if (count++ == 0) place = 0.5 * (mesh.positions()[e.edge[0]] + mesh.positions()[e.edge[1]]);
    }
    if (count > 0)
      warnings.push_back(
          fmt::format("[[hinge]] group '{}': {} of its edges lie on the boundary where nothing holds the sheet, as at "
                      "({:.4g}, {:.4g}, "
                      "{:.4g}) m: there it is a spring between the slope and the ground; take them out of the group, "
                      "or hold them by a "
                      "[[support]]",
                      hinge.group, count, place[0], place[1], place[2]));
  }
  return warnings;
}

}  // namespace voile::setup

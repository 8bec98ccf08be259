#include "parting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "mesh/border.hpp"

namespace voile::setup {

namespace {

/// Why a sheet cannot end within the mesh; empty: it can.
std::string whole_because(const input::Case& c, const mesh::SurfaceMesh& whole) {
  const auto remeshes = [](const input::Case& one) { return one.remesh.active; };
  if (remeshes(c) || std::any_of(c.stages.begin(), c.stages.end(), remeshes)) return "[remesh] keeps it whole";
  if (!c.periodics.empty()) return "[[periodic]] keeps it whole";
  if (whole.has_charts()) return "panels keep it whole";
  if (c.element.bending == energy::BendingOperator::six_node) return "this [element] type keeps it whole";
  return "";
}

std::vector<std::string> clamped_groups(const input::Case& c) {
  std::vector<std::string> names;
  const auto add = [&](const input::Case& one) {
    for (const system::Support& s : one.supports)
      if (s.kind == system::Support::Kind::clamped) names.push_back(s.group);
  };
  add(c);
  for (const input::Case& stage : c.stages) add(stage);
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace

mesh::SurfaceMesh parted(const input::Case& c, mesh::SurfaceMesh whole) {
  mesh::MeshData data = whole.data();
  for (const system::Hinge& hinge : c.hinges) {
    if (!whole.has_group(hinge.group)) continue;  // check_group_names() tells
    for (mesh::Segment edge : whole.group(hinge.group).segments) {
      std::sort(edge.begin(), edge.end());
      data.hinges.push_back(edge);
    }
  }
  const std::string why = whole_because(c, whole);
  for (const std::string& name : clamped_groups(c)) {
    if (!whole.has_group(name) || whole.group(name).dimension != 2) continue;
    const std::vector<mesh::Segment> border = mesh::inner_border(whole, whole.group(name));
    if (why.empty())
      data.borders.insert(data.borders.end(), border.begin(), border.end());
    else if (!border.empty())
      data.notes.push_back(
          fmt::format("[[support]] group '{}': the sheet goes on within what is clamped ({}), and bends there within a "
                      "fraction of a "
                      "cell; leave the held piece out and clamp its edge",
                      name, why));
  }
  if (data.hinges.empty() && data.borders.empty() && data.notes.size() == whole.data().notes.size()) return whole;
  for (std::vector<mesh::Segment>* edges : {&data.hinges, &data.borders}) std::sort(edges->begin(), edges->end());
  return mesh::SurfaceMesh(std::move(data));
}

}  // namespace voile::setup

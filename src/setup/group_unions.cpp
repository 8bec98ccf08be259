// Lists of groups that count as one.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "base/group_list.hpp"
#include "group_names.hpp"
#include "input/case_lines.hpp"
#include "voile/errors.hpp"

namespace voile::setup {

namespace {

struct Named {
  const char *section, *key;
  std::string name;
};

template <class Items>
void add(std::vector<Named>& all, const char* section, const Items& items) {
  for (const auto& item : items) all.push_back({section, "group", item.group});
}

void add_names(const input::Case& c, std::vector<Named>& all) {
  add(all, "support", c.supports);
  add(all, "load", c.loads);
  add(all, "temperature", c.temperatures);
  add(all, "hinge", c.hinges);
  add(all, "mass", c.masses);
  add(all, "spring", c.springs);
  for (const system::Spring& s : c.springs) all.push_back({"spring", "to", s.to});
  add(all, "initial_velocity", c.initial_velocities);
  add(all, "probe", c.probes);
  for (const input::Case& stage : c.stages) add_names(stage, all);
}

template <class Item>
void sort_once(std::vector<Item>& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

/// Segments of two groups that run either way are one.
void sort_segments(std::vector<mesh::Segment>& segments) {
  for (mesh::Segment& s : segments) std::sort(s.begin(), s.end());
  sort_once(segments);
}

mesh::Group united(const input::Case& c, const mesh::SurfaceMesh& mesh, const Named& named,
                   const std::vector<std::string>& groups) {
  constexpr std::array kinds{"a point", "a curve", "a surface"};
  mesh::Group all = mesh.group(groups.front());
  all.name = named.name;
  for (std::size_t k = 1; k < groups.size(); ++k) {
    const mesh::Group& one = mesh.group(groups[k]);
    if (one.dimension != all.dimension)
      throw UserError(fmt::format(
          "{}: [[{}]] {}: '{}' is {} and '{}' {}; name groups of one kind, and the others in a section of their own",
          input::place_in_case(c.file, named.section, named.key, groups[k]), named.section, named.key, groups.front(),
          kinds[static_cast<std::size_t>(all.dimension)], groups[k], kinds[static_cast<std::size_t>(one.dimension)]));
    all.vertices.insert(all.vertices.end(), one.vertices.begin(), one.vertices.end());
    all.segments.insert(all.segments.end(), one.segments.begin(), one.segments.end());
    all.triangles.insert(all.triangles.end(), one.triangles.begin(), one.triangles.end());
  }
  sort_once(all.vertices);
  sort_segments(all.segments);
  sort_once(all.triangles);
  return all;
}

void require_same(const input::Case& c, const Named& named, const mesh::Group& all, mesh::Group known) {
  sort_once(known.vertices);
  if (known.vertices == all.vertices) return;
  throw UserError(fmt::format(
      "{}: [[{}]] {}: the mesh has a group '{}' of its own, which is not the list of these groups; rename it",
      input::place_in_case(c.file, named.section, named.key, named.name), named.section, named.key, named.name));
}

}  // namespace

mesh::SurfaceMesh with_group_unions(const input::Case& c, mesh::SurfaceMesh mesh) {
  std::vector<Named> all;
  add_names(c, all);
  std::vector<mesh::Group> unions;
  std::set<std::string> made;
  for (const Named& named : all) {
    const std::vector<std::string> groups = groups_of(named.name);
    const auto is_known = [&](const std::string& name) { return mesh.has_group(name); };
    if (groups.size() < 2 || !std::all_of(groups.begin(), groups.end(), is_known)) continue;
    if (!made.insert(named.name).second) continue;
    mesh::Group all_of_them = united(c, mesh, named, groups);
    if (is_known(named.name))  // as the mesh of a restart has it
      require_same(c, named, all_of_them, mesh.group(named.name));
    else
      unions.push_back(std::move(all_of_them));
  }
  if (unions.empty()) return mesh;
  mesh::MeshData data = mesh.data();
  for (mesh::Group& group : unions) data.groups.push_back(std::move(group));
  return mesh::SurfaceMesh(std::move(data));
}

}  // namespace voile::setup

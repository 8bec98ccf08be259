#include "voile/energy/sheet.hpp"

#include <fmt/format.h>

#include "voile/base/error.hpp"

namespace voile::energy {

std::vector<int> assign_materials(const mesh::SurfaceMesh& mesh, const std::vector<Material>& materials) {
  std::vector<int> of(static_cast<std::size_t>(mesh.triangle_count()), -1);
  int everywhere = -1;
  for (int m = 0; m < static_cast<int>(materials.size()); ++m) {
    if (materials[m].groups.empty()) {
      if (everywhere >= 0) throw UserError("[[material]]: two materials name no groups; only one can cover the rest");
      everywhere = m;
    }
    for (const std::string& name : materials[m].groups)
      for (Index t : mesh.group(name, 2).triangles) {
        if (of[t] >= 0 && of[t] != m)
          throw UserError(
              fmt::format("[[material]] groups '{}': triangle {} already has another material; let groups "
                          "not overlap",
                          name, mesh.data().triangle_tags[t]));
        of[t] = m;
      }
  }
  for (std::size_t t = 0; t < of.size(); ++t) {
    if (of[t] < 0) of[t] = everywhere;
    if (of[t] < 0)
      throw UserError(
          fmt::format("[[material]]: triangle {} of {} has no material; name its group, or leave out "
                      "`groups` in one [[material]] to cover the rest",
                      mesh.data().triangle_tags[t], mesh.source()));
  }
  return of;
}

}  // namespace voile::energy

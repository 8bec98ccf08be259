#include "gas_rims.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mesh_report.hpp"
#include "system/constraints.hpp"
#include "system/gas_surface.hpp"

namespace voile::setup {

std::vector<std::string> moving_rims(const input::Case& c, const system::Model& model) {
  const auto& supports = model.discretisation().constraints().vertices;
  const mesh::SurfaceMesh& mesh = model.dofs().mesh();
  const auto is_held = [&](Index v) {
    const auto at = supports.find(v);
    return at != supports.end() && std::count(at->second.fixed.begin(), at->second.fixed.end(), true) == 3;
  };
  for (const system::Load& load : c.loads) {
    if (load.kind != system::Load::Kind::gas || load.added_volume == 0.0) continue;
    for (const system::GasSurface::Rim& rim : system::gas_surface(mesh, load).rims) {
      const auto loose = std::find_if_not(rim.vertices.begin(), rim.vertices.end(), is_held);
      if (loose != rim.vertices.end())
        return {
            fmt::format("[[load]] of type \"gas\": its rim moves at {}, and what added_volume stands for moves with "
                        "it, without any "
                        "change of volume: hold the rim, or close the gas by triangles of the mesh",
                        place_text(mesh.positions()[*loose]))};
    }
  }
  return {};
}

}  // namespace voile::setup

// Area and mass of the panels of a garment.
#pragma once

#include <string>
#include <vector>

#include "energy/material.hpp"
#include "mesh/surface_mesh.hpp"
#include "system/seam_rules.hpp"

namespace voile::setup {

struct PanelMeasures {
  std::string name;
  double area, allowance, mass;  ///< as meshed, of the strips along its seams [m^2], of both [kg]
};

/// Each surface group, as meshed. Not collective. Throws UserError as energy::assign_materials() does.
[[nodiscard]] std::vector<PanelMeasures> measure_panels(const mesh::SurfaceMesh& mesh,
                                                        const std::vector<energy::Material>& materials,
                                                        const std::vector<system::SeamRule>& seams);

}  // namespace voile::setup

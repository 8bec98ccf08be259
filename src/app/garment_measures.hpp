// What a pattern maker wants to know at the end of a run: panels, tension of seams, ease; private to src/app.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "input/case.hpp"
#include "system/ease.hpp"
#include "system/model.hpp"
#include "system/seam_tension.hpp"
#include "system/state.hpp"

namespace voile::app {

struct GarmentMeasures {
  struct Panel {
    std::string name;
    double area, allowance, mass;  ///< as meshed, of the strips along its seams [m^2], of both [kg]
  };
  std::vector<Panel> panels;
  std::vector<system::SeamTension> seams;  ///< those that are sewn, by springs or welded
  std::optional<system::EaseRange> ease;   ///< with a body
  std::optional<double> largest_pressure;  ///< of contact, with contact [Pa]
};

/// Of the state of a model of panels, obstacles at the time in force; on rank 0, nothing elsewhere. Collective.
[[nodiscard]] GarmentMeasures measure_garment(const input::Case& c, system::Model& model, const system::State& state);

/// Each surface group, as meshed. Not collective. Throws UserError as energy::assign_materials() does.
[[nodiscard]] std::vector<GarmentMeasures::Panel> measure_panels(const mesh::SurfaceMesh& mesh,
                                                                 const std::vector<energy::Material>& materials,
                                                                 const std::vector<system::SeamRule>& seams);

}  // namespace voile::app

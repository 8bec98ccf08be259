// What a pattern maker wants to know at the end of a run: panels, tension of seams, ease.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "input/case.hpp"
#include "setup/panel_measures.hpp"
#include "system/ease.hpp"
#include "system/model.hpp"
#include "system/seam_tension.hpp"
#include "system/state.hpp"

namespace voile::record {

struct GarmentMeasures {
  std::vector<setup::PanelMeasures> panels;
  std::vector<system::SeamTension> seams;  ///< those that are sewn, by springs or welded
  std::optional<system::EaseRange> ease;   ///< with a body
  std::optional<double> largest_pressure;  ///< of contact, with contact [Pa]
};

/// Of the state of a model of panels, obstacles at the time in force; on rank 0, nothing elsewhere. Collective.
[[nodiscard]] GarmentMeasures measure_garment(const input::Case& c, system::Model& model, const system::State& state);

/// Widest gap of the seams that a stage closes, on rank 0, from displacements gathered there; elsewhere 0. [m]
[[nodiscard]] double seam_gap(const input::Case& c, const mesh::SurfaceMesh& mesh,
                              const std::vector<double>& displacement);

}  // namespace voile::record

// Parameters of motion in time; symbols in dynamics.hpp.
#pragma once

#include <functional>
#include <vector>

#include "energy/drag_options.hpp"

namespace voile::system {

enum class Mass { consistent, lumped };

struct DynamicsOptions {
  Mass mass = Mass::lumped;
  bool any_mass = false;         ///< materials without a mass move with that of ConstantMatrices::mass()
  double mass_damping = 0.0;     ///< alpha [1/s]
  double bending_damping = 0.0;  ///< beta [s]
  double viscous_time = 0.0;     ///< tau [s]
  bool material_damping = true;  ///< materials damp as they say, besides
  std::vector<double> ratios;    ///< of the modes in a frequency response: of each, the last for all after; empty: none
  energy::DragOptions drag;
  std::function<double(double time)> load_history;  ///< lambda(t); empty: 1
};

}  // namespace voile::system

// Work of the forces of a model in a displacement, each kind for itself.
#pragma once

#include "base/petsc.hpp"

namespace voile::system {

class Model;

/// Works of forces in a displacement [J]; positive where a load does it, or where the others take energy from the motion.
struct ForceWork {
  double internal = 0.0, viscous = 0.0;  ///< of what is stored, and of the viscosity of the time step
  double contact = 0.0, friction = 0.0, loads = 0.0;
};

/// Of the forces at a in `displacement`, all components. Overwrites f with the unbalanced force (model.hpp) and `work`, a
/// vector of the same kind, with the applied forces. Collective.
[[nodiscard]] ForceWork work_of_forces(Model& model, Vec a, Vec displacement, Vec f, Vec work);

}  // namespace voile::system

#include "model_input.hpp"

namespace voile::app {

system::ModelInput model_input(const input::Case& c, KnownObstacles& known) {
  return {c.element,
          c.materials,
          c.supports,
          c.loads,
          contact_input(PETSC_COMM_WORLD, c, known),
          c.masses,
          c.springs,
          c.analysis == "static",
          {c.stage.sew, c.sewing.stiffness, c.sewing.speed, 0.0}};
}

}  // namespace voile::app

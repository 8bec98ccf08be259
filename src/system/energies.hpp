// Energies of a model, by kind.
#pragma once

namespace voile::system {

struct Energies {
  double membrane = 0.0, bending = 0.0;  ///< [J]
  double external = 0.0;                 ///< work potential of dead loads, -f.u [J]
  double contact = 0.0;                  ///< barriers [J]
  double springs = 0.0;                  ///< [J]
};

}  // namespace voile::system

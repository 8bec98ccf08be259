// Parameters of contact.
#pragma once

namespace voile::contact {

struct ContactOptions {
  double distance = 1e-3;      ///< at which the barrier begins [m]
  double stiffness = 1e4;      ///< kappa [Pa]
  double slip_speed = 1e-3;    ///< below it friction is smoothed [m/s]
  double slip_distance = 0.0;  ///< the same per load step where there is no time [m]; 0: a thousandth of a cell
  double settle_time = 0.1;    ///< in which a motion lets out what is nearer than `distance` at its start [s]
};

}  // namespace voile::contact

// A short damped motion that takes the noise out of a membrane which has got new vertices.
//
// Symbols   E    potential of the model [J];  M lumped mass [kg];  a_0 state at the beginning [m];  tau a time [s]
//           p    forces [N], or none
//   minimises  E(a) - p.a + 1/2 (a - a_0).M (a - a_0) / tau^2   by Newton's method with a positive tangent, a few iterations
// In a motion p = -M x acceleration, by which internal and applied forces are out of balance: what stops an impact is kept.
// A motion must not lose what the membrane and contact store far from new vertices: there M is made so much larger that the
// old state stays.
// Stretches over an edge h relax if tau is several times h sqrt(rho / (E h)), the time in which the membrane carries a
// signal over it; long waves and the centre of mass hardly move.
// Source: S. Martin et al., ACM TOG 30 (2011), article 72 (a step as a minimum).
#pragma once

#include <vector>

#include "system/model.hpp"

namespace voile::solve {

struct Relaxation {
  int steps = 0;
  int factorisations = 0;
  double moved = 0.0;  ///< largest component of the displacement [m]
};

struct RelaxationOptions {
  double tau = 0.0;  ///< [s]
  int steps = 2;     ///< at most
  std::vector<char> stays =
      {};               ///< per vertex of the mesh, the same on every rank: stays where it is; empty: none does
  Vec force = nullptr;  ///< p; the caller's [N]
};

/// From and into `a`, whose prescribed components are put right first. Contact bounds every iteration, and no iteration
/// increases what is minimised. With p, as in a motion, systems are solved by voile_inexact unless options say otherwise.
/// Collective.
[[nodiscard]] Relaxation relax(system::Model& model, Vec a, const RelaxationOptions& options);

/// The time tau that suits the model: some times that of a signal over a cell. [s]
[[nodiscard]] double relaxation_time(const system::Model& model);

}  // namespace voile::solve

// From any start to a stable static equilibrium under the full loads.
//
// Pseudo-transient continuation (newton.hpp) finds an equilibrium; the negative pivots of its exact tangent say whether
// it is stable. An unstable one (a flat sheet, a symmetric fold) is left along its lowest mode and the search goes on.
// Without contact and from the unloaded state the cheap way comes first: a few load steps of Newton's method, which
// count if no tangent on the way is indefinite. With contact the sheet first falls, with inertia and kinetic damping,
// until it nearly rests; friction then acts against slips from there. A search that takes much longer than the fall is
// given up for another fall to a lower speed, and so on. What is returned as converged is at rest by definition: in the
// search there is no inertia. Source: C. T. Kelley & D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508-523.
#pragma once

#include <memory>

#include "drape_options.hpp"
#include "stepper.hpp"

namespace voile::solve {

/// What is known of the state that a drape has come to.
struct Stability {
  double residual = 0.0;    ///< |r| [N]
  bool stable = false;      ///< no negative pivot; false too if the linear solver does not tell
  double eigenvalue = 0.0;  ///< of the tangent in the lumped mass, nearest to zero [1/s^2]
  int escapes = 0;          ///< from unstable equilibria
  int fall_iterations = 0;  ///< of Newton's method, in falls
};

/// One step: a whole drape. Each attempt is a search with the falls before it; an unstable equilibrium is left for the
/// next attempt.
class Drape : public Stepper {
 public:
  /// The model must outlive it. Collective.
  Drape(system::Model& model, DrapeOptions options);
  ~Drape() override;

  /// Loads act in full from here: the model's load factor becomes 1.
  [[nodiscard]] StepResult begin(system::State& state) override;
  [[nodiscard]] StepResult advance(system::State& state) override;
  [[nodiscard]] bool finished(const system::State& state) const override;
  [[nodiscard]] const Stability& stability() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voile::solve

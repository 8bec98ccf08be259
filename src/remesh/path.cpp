// How a path goes on on a new mesh.
#include <fmt/format.h>

#include "record/probes.hpp"
#include "remesher.hpp"
#include "solve/path_following.hpp"

namespace voile::remesh {

/// Under a given load without contact: the equilibrium of the new mesh is near, and relaxation would only be on the way.
/// False where it was not found, or where the load is not what is followed. Collective.
bool Remesher::find_equilibrium_nearby(Epoch& fresh) const {
  if (stage_.c.analysis != input::Analysis::statics || stage_.c.steps.control != solve::StaticOptions::Control::load)
    return false;
  if (fresh.model().contact()) return false;
  return solve::regain_equilibrium(fresh.model(), fresh.state()).outcome != solve::Outcome::failed;
}

/// Brings what the old mesh had in equilibrium to one of the new mesh: at its load, where that is what is followed,
/// otherwise at its place along the path. Collective.
bool Remesher::find_equilibrium(Epoch& old_epoch, Epoch& fresh, std::string& what) const {
  using Options = solve::StaticOptions;
  const Options& steps = stage_.c.steps;
  system::State& state = fresh.state();
  state.in_equilibrium = false;
  what = "no equilibrium was found on the new mesh";
  if (steps.control == Options::Control::load)
    return solve::regain_equilibrium(fresh.model(), state).outcome != solve::Outcome::failed ||
           solve::find_equilibrium(fresh.model(), state).outcome != solve::Outcome::failed;
  petsc::VecHandle probe;
  double probed = 0.0;
  if (!steps.control_probe.empty()) {
    const auto functional = [&](const system::Model& model) {
      return record::Probes(stage_.c, model).functional(steps.control_probe, model);
    };
    probe = functional(fresh.model());
    VOILE_PETSC(VecDot(functional(old_epoch.model()), old_epoch.state().u, &probed));
  }
  const solve::NewtonResult n = solve::PathFollower(fresh.model(), steps, probe).regain(state, probed);
  if (!n.converged) {
    what += ": " + n.reason;
    return false;
  }
  const long before = state.path.negative_pivots;
  if (steps.at_critical_point == Options::AtCriticalPoint::pass || before < 0 || n.negative_pivots == before)
    return true;
  what =
      fmt::format("a critical point where the path is to stop or branch would be left behind (negative pivots: {}, {})",
                  before, n.negative_pivots);
  return false;
}

}  // namespace voile::remesh

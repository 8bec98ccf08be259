#include "single_step.hpp"

#include "load_path.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

namespace {

StepResult result_of(const NewtonResult& n) {
  StepResult r;
  r.newton = n;
  r.newton_iterations = n.iterations;
  r.factorisations = n.factorisations;
  if (n.converged) return r;
  r.outcome = Outcome::failed;
  r.reason = n.reason;
  return r;
}

}  // namespace

StepResult LinearStep::begin(system::State& state) {
  model_.conditions().set_load_factor(state.load_factor);
  constexpr double most = 1e-6;  // round-off is less
  if (model_.potential().unbalanced_membrane(state.u) > most)
    throw UserError(
        "analysis = \"linear\": an initial strain, a prestress or a constant temperature would move the sheet before "
        "any "
        "load acts, and stresses that then go would stiffen or soften it; use analysis = \"static\", hold the sheet, "
        "or let "
        "the temperature grow with the load factor (constant = false)");
  return {};
}

bool LinearStep::finished(const system::State&) const {
  return done_;
}

StepResult LinearStep::advance(system::State& state) {
  Newton newton(model_);
  model_.conditions().set_load_factor(load_factor_);
  StepResult r = result_of(newton.linear_step(state.u));
  done_ = r.outcome == Outcome::accepted;
  if (!done_) return r;
  r.taken = 1.0;
  ++state.step;
  state.load_factor = load_factor_;
  return r;
}

StepResult Equilibrium::begin(system::State& state) {
  if (StepResult r = find_equilibrium(model_, state); r.outcome == Outcome::failed || !search_) return r;
  Newton newton(model_);
  NewtonResult n = newton.step(state.u);
  if (!n.converged) {
    VOILE_PETSC(VecZeroEntries(state.u));
    n = newton.continuation(state.u);
  }
  state.in_equilibrium = n.converged;
  if (n.converged) model_.potential().end_step(state.u);
  return result_of(n);
}

StepResult Equilibrium::advance(system::State&) {
  return {};
}

}  // namespace voile::solve

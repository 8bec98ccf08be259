#include "voile/solve/static_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voile::solve {

namespace {

/// Halvings in a row before continuation is tried.
constexpr int halvings_before_continuation = 1;

}  // namespace

double StaticPath::next_target(double from, double step) const {
  const double direction = options_.final_load_factor >= 0.0 ? 1.0 : -1.0;
  const double slack = 1e-9 * std::max(1.0, std::abs(options_.final_load_factor));
  // A remainder of less than a tenth of a step is taken along; the nearest stop within reach wins.
  double nearest = 1.1 * step, target = from + direction * step;
  const auto limit = [&](double stop, double least) {
    const double distance = direction * (stop - from);
    if (distance <= least || distance >= nearest) return;
    nearest = distance;
    target = stop;
  };
  limit(options_.final_load_factor, 0.0);
  for (const double stop : options_.stops) limit(stop, slack);
  return target;
}

PathResult StaticPath::run(Vec a) {
  Newton newton(model_);
  PathResult result;
  petsc::VecHandle accepted = model_.create_vector();
  VOILE_PETSC(VecCopy(a, accepted));
  model_.set_load_factor(0.0);
  if (observer_) observer_({}, a);
  double factor = 0.0, step = options_.initial_step;
  int halvings = 0;
  const auto tally = [&](const NewtonResult& n) {
    result.newton_iterations += n.iterations;
    result.factorisations += n.factorisations;
  };
  while (std::abs(options_.final_load_factor - factor) > 1e-12 * std::max(1.0, std::abs(options_.final_load_factor))) {
    const double target = next_target(factor, step), taken = std::abs(target - factor);
    model_.set_load_factor(target);
    NewtonResult n = newton.step(a);
    tally(n);
    bool by_continuation = false;
    if (!n.converged && options_.fallback && halvings == halvings_before_continuation) {
      remark(fmt::format("load factor {:.6g}: {} after {} iterations; trying pseudo-transient continuation", target,
                         n.reason, n.iterations));
      VOILE_PETSC(VecCopy(accepted, a));
      n = newton.continuation(a);
      tally(n);
      by_continuation = true;
    }
    if (!n.converged) {
      VOILE_PETSC(VecCopy(accepted, a));
      ++halvings;
      step = 0.5 * taken;
      remark(fmt::format("load factor {:.6g}: {} after {} iterations; step halved to {:.3g}", target, n.reason,
                         n.iterations, step));
      if (step < options_.min_step) {
        result.reason = fmt::format(
            "no equilibrium found beyond load factor {:.6g} with steps of {:.3g} or more; the "
            "last attempt ended with {}",
            factor, options_.min_step, n.reason);
        break;
      }
      continue;
    }
    VOILE_PETSC(VecCopy(a, accepted));
    factor = target;
    ++result.steps;
    const bool last =
        std::abs(options_.final_load_factor - factor) <= 1e-12 * std::max(1.0, std::abs(options_.final_load_factor));
    if (observer_) observer_({result.steps, factor, n, by_continuation, last}, a);
    // A step cut short by a stop says nothing against the step size in force; one after a failure does not grow,
    // unless continuation took it, which does not mind long steps.
    const bool easy = by_continuation || (n.iterations <= options_.target_iterations && halvings == 0);
    if (easy && taken > 0.9 * step) step = std::min(options_.max_step, 2.0 * step);
    halvings = 0;
  }
  result.load_factor = factor;
  result.completed = result.reason.empty();
  model_.set_load_factor(factor);
  return result;
}

}  // namespace voile::solve

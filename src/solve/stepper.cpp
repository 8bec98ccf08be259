#include "stepper.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace voile::solve {

const char* name(CriticalPoint::Kind kind) {
  switch (kind) {
    case CriticalPoint::Kind::limit:
      return "limit point";
    case CriticalPoint::Kind::bifurcation:
      return "bifurcation point";
    case CriticalPoint::Kind::both:
      break;
  }
  return "limit and bifurcation point";
}

std::string text_of(const CriticalPoint& point) {
  std::string there = fmt::format("{} at load factor {:.6g}", name(point.kind), point.load_factor);
  if (!point.between) return there;
  const auto [low, high] = std::minmax((*point.between)[0], (*point.between)[1]);
  std::string between = fmt::format("bifurcation point between load factors {:.6g} and {:.6g}", low, high);
  if (point.kind == CriticalPoint::Kind::bifurcation) return between;
  return fmt::format("limit point at load factor {:.6g}, {}", point.load_factor, between);
}

void RunStatistics::add(const StepResult& r) {
  newton_iterations += r.newton_iterations;
  factorisations += r.factorisations;
  iterative.add(r.iterative);
  rejections += r.rejections;
  if (r.newton.eigenvalue) eigenvalue = r.newton.eigenvalue;
  if (r.outcome == Outcome::failed) {
    reason = r.reason;
    interrupted = r.interrupted;
  }
  if (r.outcome == Outcome::accepted && r.taken == 0.0 && steps == 0)  // of the start, where no step is left to take
    newton.negative_pivots = r.newton.negative_pivots;
  if (r.outcome != Outcome::accepted || r.taken == 0.0) return;
  ++steps;
  newton = r.newton;
  if (r.critical) critical.push_back(*r.critical);
}

RunStatistics follow(Stepper& stepper, system::State& state,
                     const std::function<bool(const system::State&, const StepResult&)>& look) {
  RunStatistics all;
  for (StepResult r = stepper.begin(state);; r = stepper.advance(state)) {
    all.add(r);
    if (r.outcome == Outcome::failed) return all;
    if (r.outcome == Outcome::accepted && look && look(state, r)) return all;
    if (!stepper.finished(state)) continue;
    all.completed = true;
    return all;
  }
}

}  // namespace voile::solve

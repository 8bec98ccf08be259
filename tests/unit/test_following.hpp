// Steppers followed to their end from vectors that a test owns.
#pragma once

#include "solve/stepper.hpp"
#include "solve/time_integration.hpp"

namespace voile::testing {

/// A state in these vectors.
inline system::State state_of(Vec u, Vec v = nullptr) {
  system::State s;
  s.u = petsc::fraction(u);
  if (v) s.v = petsc::fraction(v);
  return s;
}

/// What came of a stepper, with the last state.
struct Ended : solve::RunStatistics {
  system::State state;
};

using Look = std::function<bool(const system::State&, const solve::StepResult&)>;

inline Ended follow_from(system::State state, solve::Stepper& stepper, const Look& look = {}) {
  Ended e;
  e.state = std::move(state);
  static_cast<solve::RunStatistics&>(e) = solve::follow(stepper, e.state, look);
  return e;
}

/// A recorded step of a path.
struct Report : solve::StepResult {
  int step = 0;
  double load_factor = 0.0;
  bool last = false;
  Report(const system::State& s, const solve::StepResult& r, bool is_last)
      : solve::StepResult(r), step(s.step), load_factor(s.load_factor), last(is_last) {}
};

/// A motion with patience.
inline solve::TimeOptions motion_options(double end, double step) {
  solve::TimeOptions o;
  o.end_time = end;
  o.step = step;
  o.target_iterations = 100;
  return o;
}

}  // namespace voile::testing

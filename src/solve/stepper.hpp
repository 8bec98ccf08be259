// What advances a state by one accepted step and returns: load path, path following, time integration, drape.
//
// `begin` takes the state it is to continue from; then `advance`, until the stepper has `finished` or fails:
//     StepResult r = stepper.begin(state);
//     while (r.outcome != Outcome::failed && !stepper.finished(state)) r = stepper.advance(state);
// Between two calls the caller may record the state, or leave and go on with another model from the same state.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "newton.hpp"
#include "system/state.hpp"

namespace voile::solve {

/// Where the tangent became singular between two accepted states.
struct CriticalPoint {
  enum class Kind { limit = 1, bifurcation = 2, both = 3 };  ///< numbers as in history.csv
  Kind kind = Kind::limit;
  int step = 0;              ///< the first accepted step behind it
  double load_factor = 0.0;  ///< interpolated between the two states
  /// Of a bifurcation whose eigenvalue was not followed: between these, the load factors of the two states.
  std::optional<std::array<double, 2>> between{};
};
/// Whether its load factor is more than the middle of a step.
[[nodiscard]] inline bool is_located(const CriticalPoint& p) {
  return p.kind != CriticalPoint::Kind::bifurcation || !p.between;
}
[[nodiscard]] const char* name(CriticalPoint::Kind kind);
/// What it is and at which load factor.
[[nodiscard]] std::string text_of(const CriticalPoint& point);

enum class Outcome {
  accepted,  ///< the state is one step further
  not_yet,   ///< an attempt failed and the next one is smaller, or a search goes on; the state may serve as before
  failed     ///< nothing more can be done: `reason`
};

/// Systems that were solved by conjugate gradients instead of a factor (inexact_pc.hpp).
struct IterativeEffort {
  long solutions = 0, iterations = 0;
  long shifted = 0;             ///< incomplete factors that needed a shift
  long negative_curvature = 0;  ///< tangents found indefinite
  void add(const IterativeEffort& more) {
    solutions += more.solutions;
    iterations += more.iterations;
    shifted += more.shifted;
    negative_curvature += more.negative_curvature;
  }
};

struct StepResult {
  Outcome outcome = Outcome::accepted;
  std::string reason;                             ///< why it failed
  bool interrupted = false;                       ///< by a signal (base/interrupt.hpp); then it has failed
  bool worth_keeping = false;                     ///< failed, but the state has moved towards what was looked for
  double taken = 0.0;                             ///< size of the step; 0 at the start
  NewtonResult newton;                            ///< of the accepted step
  int newton_iterations = 0, factorisations = 0;  ///< spent by the call, failed attempts included
  IterativeEffort iterative;                      ///< likewise
  int rejections = 0;                             ///< attempts that failed before
  int cut_short = 0;                              ///< iterations that contact did not let go the whole way
  double shortest = 1.0;                          ///< fraction of its increment that the most hindered iteration went
  bool by_continuation = false;
  std::optional<CriticalPoint> critical;  ///< passed since the step before
  Vec mode = nullptr;                     ///< critical mode, where the path stops or branches; belongs to the stepper
};

class Stepper {
 public:
  /// Called on every rank with remarks on cut steps, critical points and searches.
  using Remark = std::function<void(const std::string&)>;

  Stepper() = default;
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;
  virtual ~Stepper() = default;

  /// Prepares to continue from the state, and puts its prescribed components right. Collective.
  [[nodiscard]] virtual StepResult begin(system::State& state) = 0;
  /// One step, or one attempt. On failure the state is the last accepted one. Collective.
  [[nodiscard]] virtual StepResult advance(system::State& state) = 0;
  /// Whether the end is reached. Collective.
  [[nodiscard]] virtual bool finished(const system::State& state) const = 0;

  void on_remark(Remark remark) { remark_ = std::move(remark); }
  /// How far the search for a state has come, again and again.
  void on_progress(Remark progress) { progress_ = std::move(progress); }

 protected:
  void remark(const std::string& text) const {
    if (remark_) remark_(text);
  }
  [[nodiscard]] const Remark& remarks() const { return remark_; }
  [[nodiscard]] const Remark& progress() const { return progress_; }

 private:
  Remark remark_, progress_;
};

/// What many steps came to.
struct RunStatistics {
  bool completed = false;
  int steps = 0, rejections = 0;
  int newton_iterations = 0, factorisations = 0;  ///< failed attempts included
  IterativeEffort iterative;
  NewtonResult newton;  ///< of the last accepted step
  std::vector<CriticalPoint> critical;
  std::optional<double> eigenvalue;  ///< nearest to zero, of the last state that a drape has judged [1/s^2]
  bool interrupted = false;
  std::string reason;  ///< why it ended early

  void add(const StepResult& r);
};

/// Follows a stepper to its end. `look` sees the start and every accepted step; it may change the velocity, and ends
/// the matter by returning true. Collective.
RunStatistics follow(Stepper& stepper, system::State& state,
                     const std::function<bool(const system::State&, const StepResult&)>& look = {});

}  // namespace voile::solve

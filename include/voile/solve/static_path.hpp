// Quasi-static load path: the load factor grows in steps that adapt to Newton's effort.
//
// A step that converges in few iterations lets the next one grow by up to 2; a step that fails is halved. If the half
// fails too, pseudo-transient continuation is tried there once (if allowed), and stepping goes on from what it finds.
#pragma once

#include <functional>
#include <string>

#include "voile/solve/newton.hpp"
#include "voile/solve/static_options.hpp"

namespace voile::solve {

/// One accepted equilibrium.
struct StepReport {
  int step = 0;
  double load_factor = 0.0;
  NewtonResult newton;
  bool by_continuation = false;
  bool last = false;
};

struct PathResult {
  bool completed = false;
  int steps = 0;
  int newton_iterations = 0;  ///< failed attempts included
  int factorisations = 0;     ///< failed attempts included
  double load_factor = 0.0;
  std::string reason;  ///< why it ended early
};

class StaticPath {
 public:
  using Observer = std::function<void(const StepReport&, Vec a)>;
  using Remark = std::function<void(const std::string&)>;

  StaticPath(system::Model& model, StaticOptions options) : model_(model), options_(std::move(options)) {}
  /// Called collectively with every accepted state; the first call is the unloaded start as step 0.
  void on_step(Observer observer) { observer_ = std::move(observer); }
  /// Called on every rank with remarks on cut steps.
  void on_remark(Remark remark) { remark_ = std::move(remark); }

  /// Follows the path from `a` at load factor 0. Collective. `a` ends at the last accepted state.
  [[nodiscard]] PathResult run(Vec a);

 private:
  [[nodiscard]] double next_target(double from, double step) const;
  void remark(const std::string& text) const {
    if (remark_) remark_(text);
  }

  system::Model& model_;
  StaticOptions options_;
  Observer observer_;
  Remark remark_;
};

}  // namespace voile::solve

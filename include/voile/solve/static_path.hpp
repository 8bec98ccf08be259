// Quasi-static load path: the load factor grows in steps that adapt to Newton's effort.
//
// A step that converges in few iterations lets the next one grow by up to 2; a step that fails is halved. If the half
// fails too, pseudo-transient continuation is tried there once (if allowed), and stepping goes on from what it finds.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "voile/solve/newton.hpp"
#include "voile/solve/static_options.hpp"

namespace voile::solve {

/// Where the tangent became singular between two accepted states.
struct CriticalPoint {
  enum class Kind { limit = 1, bifurcation = 2, both = 3 };  ///< numbers as in history.csv
  Kind kind = Kind::limit;
  int step = 0;              ///< the first accepted step behind it
  double load_factor = 0.0;  ///< interpolated between the two states
};
[[nodiscard]] const char* name(CriticalPoint::Kind kind);

/// One accepted equilibrium.
struct StepReport {
  int step = 0;
  double load_factor = 0.0;
  NewtonResult newton;
  bool by_continuation = false;
  bool last = false;
  std::optional<CriticalPoint> critical;  ///< passed since the step before
  Vec mode = nullptr;                     ///< critical mode, where the path stops or branches; not owned
};

struct PathResult {
  bool completed = false;
  int steps = 0;
  int newton_iterations = 0;  ///< failed attempts included
  int factorisations = 0;     ///< failed attempts included
  double load_factor = 0.0;
  std::string reason;  ///< why it ended early
  std::vector<CriticalPoint> critical;
};

/// A converged state to go on from.
struct PathStart {
  int step = 0;
  double load_factor = 0.0;
  Vec previous = nullptr;  ///< the state one step before, which gives the path its direction; may be null; not owned
};

/// Options -path_... of PETSc, which win over the case file. Collective.
void read_path_options(MPI_Comm comm, StaticOptions& options);

/// What both ways of following a path share.
class PathBase {
 public:
  using Observer = std::function<void(const StepReport&, Vec a)>;
  using Remark = std::function<void(const std::string&)>;

  PathBase(system::Model& model, StaticOptions options) : model_(model), options_(std::move(options)) {}
  /// Called collectively with every accepted state; the first call is the start.
  void on_step(Observer observer) { observer_ = std::move(observer); }
  /// Called on every rank with remarks on cut steps and critical points.
  void on_remark(Remark remark) { remark_ = std::move(remark); }

 protected:
  void remark(const std::string& text) const {
    if (remark_) remark_(text);
  }
  void observe(const StepReport& report, Vec a) const {
    if (observer_) observer_(report, a);
  }

  system::Model& model_;
  StaticOptions options_;

 private:
  Observer observer_;
  Remark remark_;
};

/// Load control.
class StaticPath : public PathBase {
 public:
  using PathBase::PathBase;
  /// Follows the path from `a` at start.load_factor. Collective. `a` ends at the last accepted state, after a signal
  /// too (see base/interrupt.hpp).
  [[nodiscard]] PathResult run(Vec a, const PathStart& start = {});

 private:
  struct Walk;
  [[nodiscard]] double next_target(double from, double step) const;
  [[nodiscard]] bool is_final(double factor) const;
  [[nodiscard]] bool advance(Walk& w, Vec a);
  [[nodiscard]] bool halve(Walk& w, Vec a, const NewtonResult& n, double target, double taken);
};

}  // namespace voile::solve

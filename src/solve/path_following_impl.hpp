// The inner parts of PathFollower; private to src/solve.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "linear/inverse_iteration.hpp"
#include "path_following.hpp"

namespace voile::solve {

using Control = StaticOptions::Control;
using AtCriticalPoint = StaticOptions::AtCriticalPoint;

/// Of Tangent::pushed: below it the load does no work on the mode.
inline constexpr double not_pushed = 1e-3;

struct PathFollower::Impl {
  system::Model& model;
  const StaticOptions options;
  const Remark& remark;
  Newton newton;
  linear::LinearSolver& linear;
  petsc::VecHandle probe;                          ///< c
  petsc::VecHandle accepted, increment, previous;  ///< accepted state, Da, the increment that led to the accepted state
  petsc::VecHandle tangent_solution;               ///< x_f of the accepted state
  petsc::VecHandle load_solution, residual_solution, residual, load, scratch, last_mode;
  petsc::VecHandle mode;  ///< eigenvector nearest to singularity, <mode, mode> = 1
  double factor = 0.0;    ///< load factor of the accepted state
  double rate = 0.0;      ///< dlambda/ds in the accepted state along the path
  double force = 0.0;     ///< largest scale of forces accepted: at load factor 0 the present one may vanish
  int steps = 0;          ///< accepted, those before this path included
  int iterations = 0;     ///< of Newton's method so far
  // How the next step is tried.
  double unit = 0.0;    ///< length of the step whose size is 1
  double length = 0.0;  ///< of the next step
  bool branching = false, may_branch = false, stopped = false;
  double doubted = 0.0;  ///< length of the step that has first led off the path; 0: none since it was as long again
  bool jumping = false;  ///< to another path, as this one turns back
  long together = 0;     ///< modes at the point where the path has branched
  double crowded = 0.0;  ///< length of the first step from here with critical points in doubt; 0: none
  double fastest = 0.0;  ///< largest change of the probe per length of the path so far
  double longest = 0.0;  ///< step by displacement control that was accepted
  int lengthened = 0;    ///< how often, to pass a singular tangent; -1: in vain, since the last step

  /// What the tangent at an equilibrium tells.
  struct Tangent {
    bool good = false;
    long negative_pivots = -1;  ///< likely ones, for critical points
    long certain = -1;          ///< for the verdict (linear::NegativeEigenvalues)
    double eigenvalue = 0.0;    ///< of K in W, nearest to zero
    double speed = 0.0;         ///< |x_f|
    double kept = 0.0;          ///< |<m, m'>| of its mode m and the one found at the tangent before, m'
    double pushed = 1.0;  ///< |m.f| / |m| |f| of the mode m of that eigenvalue: 0 where the load does no work on it
  } tangent;              ///< at the accepted state

  /// The scalar equation that goes with r = 0.
  struct Constraint {
    Control kind;
    double value;          ///< load: ignored; displacement: q; arc length: L
    bool nearest = false;  ///< instead: every correction is orthogonal to the path
  };

  Impl(system::Model& m, StaticOptions o, const Remark& r, Vec c)
      : model(m), options(std::move(o)), remark(r), newton(m), linear(newton.linear_solver()) {
    for (petsc::VecHandle* v : {&accepted, &increment, &previous, &tangent_solution, &load_solution, &residual_solution,
                                &residual, &load, &scratch, &last_mode})
      *v = m.dofs().create_vector();
    if (c) {
      probe = m.dofs().create_vector();
      VOILE_PETSC(VecCopy(c, probe));
    }
    mode = linear::start_mode(m);
  }

  [[nodiscard]] double dot(Vec x, Vec y) const {
    double value = 0.0;
    VOILE_PETSC(VecPointwiseMult(scratch, model.potential().constant().mass(), x));
    VOILE_PETSC(VecDot(scratch, y, &value));
    return value;
  }
  [[nodiscard]] double probed(Vec x) const {
    double value = 0.0;
    if (probe) VOILE_PETSC(VecDot(probe, x, &value));
    return value;
  }

  [[nodiscard]] Tangent tangent_at(Vec a);
  [[nodiscard]] NewtonResult correct(Vec a, double& lambda, const Constraint& constraint);
  [[nodiscard]] double load_correction(const Constraint& constraint) const;
  void predict(const Constraint& constraint, double& lambda);
  void start_from(const system::State& state);
  void begin(const system::State& state, StepResult& r);
  [[nodiscard]] NewtonResult regain(system::State& state, double probed_before);
  void require_motion(double speed) const;
  [[nodiscard]] Constraint next_constraint(double length) const;
  [[nodiscard]] Constraint fraction(const Constraint& whole, double part) const;
  [[nodiscard]] bool passes_end(Vec a, double lambda) const;
  [[nodiscard]] bool is_end(double probed, double lambda) const;
  [[nodiscard]] bool at_end() const { return is_end(probed(accepted), factor); }
  [[nodiscard]] NewtonResult land(Vec a, double& lambda);
  [[nodiscard]] bool leaves_path(const Constraint& constraint) const;
  /// Of a step of the path.
  struct Bend {
    double cosine = 1.0;  ///< of the angle between the tangents at both ends
    double aside = 0.0;   ///< part of the step that is not along their bisector
  };
  [[nodiscard]] Bend bend_of(const Tangent& after) const;
  [[nodiscard]] bool has_jumped(const Constraint& constraint, const Bend& bend) const;
  [[nodiscard]] double straighter(const Bend& bend) const;
  [[nodiscard]] NewtonResult attempt(Vec a, double& lambda, const Constraint& constraint);
  [[nodiscard]] Constraint constraint_of_place(double probed_before) const;
  [[nodiscard]] std::optional<CriticalPoint::Kind> kind_between(double rate_before, long pivots_before,
                                                                double rate_after, long pivots_after) const;
  [[nodiscard]] std::optional<CriticalPoint> passed(const Tangent& after, double lambda) const;
  [[nodiscard]] NewtonResult locate(Vec a, double& lambda, const Constraint& constraint, Tangent& after);
  [[nodiscard]] NewtonResult branch(Vec a, double& lambda, double length);
  void accept(Vec a, double lambda, const Tangent& after);
  struct Attempt {
    NewtonResult newton;
    Tangent after;
    std::optional<CriticalPoint> critical;
    bool found = false;  ///< it ends at the critical point
    Bend bend;
  };
  [[nodiscard]] Attempt try_step(Vec a, double& lambda);
  [[nodiscard]] StepResult advance(system::State& state);
  [[nodiscard]] double probe_speed() const;
  [[nodiscard]] bool is_doubtful(const CriticalPoint& point, const Tangent& after);
  [[nodiscard]] std::string ran_away(Vec a, double lambda) const;
  void jump_next();
  [[nodiscard]] bool lengthen(const StepResult& r);
  void halve(system::State& state, StepResult& r);
  [[nodiscard]] double rate_of(const Tangent& t) const {
    return std::copysign(1.0 / t.speed, dot(increment, load_solution));
  }
};

}  // namespace voile::solve

#include "drape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "base/interrupt.hpp"
#include "drape_motion.hpp"
#include "linear/inverse_iteration.hpp"
#include "stall.hpp"
#include "step_bound.hpp"
#include "system/contact.hpp"

namespace voile::solve {

namespace {

constexpr int inverse_iterations = 20;
/// Load steps of the cheap way without contact, halved steps included.
constexpr int most_load_steps = 16;
constexpr double first_load_step = 0.25;
/// Growth of the push where an escape was in vain, and the part of an energy by which a state may be lower and the same.
constexpr double push_growth = 3.0, same_energy = 1e-6;
/// From the unloaded state to the load factor in force by Newton's method; on failure `a` is unloaded again.
/// Collective.
bool ramp(Newton& newton, system::Model& model, Vec a, NewtonResult& result) {
  double norm = 0.0;
  VOILE_PETSC(VecNorm(a, NORM_2, &norm));
  const double full = model.conditions().load_factor();
  if (model.contact() || !model.conditions().symmetric() || norm > 0.0 || full == 0.0) return false;
  petsc::VecHandle accepted = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(a, accepted));
  const std::vector<double> slips = model.potential().slips();
  double done = 0.0, step = first_load_step;
  bool stable = true;
  // Clamps that turn far take steps of their own.
  const int turns = static_cast<int>(model.conditions().turn_between(0.0, full, true) / largest_turn);
  for (int k = 0; k < most_load_steps + 2 * turns && done < 1.0 && stable; ++k) {
    const double whole = std::min(1.0, done + step) - done;
    const double target = done + whole * fraction_by_turn(model, done * full, (done + whole) * full, true);
    model.conditions().set_load_factor(target * full);
    const NewtonResult n = newton.step(a);
    result.iterations += n.iterations;
    stable = !n.converged || n.negative_pivots == 0;
    if (!n.converged) {
      step *= 0.5;
      VOILE_PETSC(VecCopy(accepted, a));
      continue;
    }
    VOILE_PETSC(VecCopy(a, accepted));
    model.potential().end_step(a);
    done = target;
    if (n.iterations <= 8) step *= 2.0;
    result.converged = stable && done == 1.0;
    result.residual = n.residual;
    result.reason = n.reason;
  }
  model.conditions().set_load_factor(full);
  if (result.converged) return true;
  VOILE_PETSC(VecZeroEntries(a));
  model.potential().restore_slips(slips);
  return false;
}

using Remark = Stepper::Remark;

/// One drape: the solver, and the search from where things stand.
class Search {
 public:
  Search(system::Model& model, const DrapeOptions& options, const Remark& progress)
      : model_(model), options_(options), progress_(progress) {
    renew();
  }
  [[nodiscard]] Newton& newton() { return *newton_; }
  [[nodiscard]] int factorisations() const { return spent_ + newton_->linear_solver().factorisations(); }
  /// Iterations of falls so far.
  [[nodiscard]] int fall_iterations() const { return fall_iterations_; }

  /// An equilibrium near or far; iterations are those of this call, falls included. Collective.
  [[nodiscard]] NewtonResult run(system::State& state) {
    Vec a = state.u;
    if (!model_.contact() || !options_.fall) {
      newton_->start_friction(a);
      return ended(settle(a, options_.max_iterations));
    }
    NewtonResult result;
    int spent = 0, budget = least_search;
    double rest_speed = first_rest_speed;
    while (spent < options_.max_iterations && !result.converged) {
      if (supports_are_right(a)) {
        const FallResult fall = fall_to_rest(model_, state, rest_speed, options_.max_iterations - spent, progress_);
        spent_ += fall.factorisations;
        spent += fall.iterations;
        fall_iterations_ += fall.iterations;
        tell(fall);
        if (fall.endless) {
          result.reason = fall.reason;
          break;
        }
        budget = std::max(budget, fall.iterations);
      }
      renew();
      newton_->start_friction(a);
      result = settle(a, std::min(budget, std::max(options_.max_iterations - spent, 1)));
      spent += result.iterations;
      budget *= 2;
      rest_speed *= next_rest_speed;
    }
    result.iterations = spent;
    return ended(std::move(result));
  }

 private:
  /// Says where more iterations may help.
  [[nodiscard]] NewtonResult ended(NewtonResult result) const {
    if (!result.converged && result.iterations >= options_.max_iterations)
      result.reason +=
          fmt::format("; [drape] max_iterations = {} has ended the search: give more", options_.max_iterations);
    return result;
  }

  /// Iterations of the first search after a fall, if the fall took fewer.
  static constexpr int least_search = 100;
  /// Cells per unit of time (drape_motion.hpp) at which a search takes over from the first fall, and the factor on it
  /// for the falls after searches that failed.
  static constexpr double first_rest_speed = 0.05, next_rest_speed = 0.2;

  /// A solver for the matrix as it is now: falls change its pattern.
  void renew() {
    if (newton_) spent_ += newton_->linear_solver().factorisations();
    newton_ = std::make_unique<Newton>(model_);
    if (progress_)
      newton_->on_progress([this](int iteration, double norm) {
        progress_(fmt::format("search: {} iterations, residual {:.2e}", iteration, norm));
      });
  }
  [[nodiscard]] NewtonResult settle(Vec a, int most) {
    const auto search = [&] { return newton_->continuation(a, most); };
    return newton_->settle_friction(a, search(), search);
  }
  void tell(const FallResult& fall) const {
    if (!progress_) return;
    progress_(fmt::format("fall: {} steps, {} iterations, {}", fall.steps, fall.iterations,
                          fall.rested ? "nearly at rest" : fall.reason));
  }
  /// Supports that are still to be moved would jump at the start of a motion.
  [[nodiscard]] bool supports_are_right(Vec a) const {
    petsc::VecHandle moved = model_.dofs().create_vector();
    double distance = 0.0;
    VOILE_PETSC(VecCopy(a, moved));
    model_.conditions().enforce(moved);
    VOILE_PETSC(VecAXPY(moved, -1.0, a));
    VOILE_PETSC(VecNorm(moved, NORM_INFINITY, &distance));
    return distance <= 1e-12 * model_.dofs().mesh().extent();
  }

  system::Model& model_;
  const DrapeOptions& options_;
  const Remark& progress_;
  std::unique_ptr<Newton> newton_;
  int spent_ = 0, fall_iterations_ = 0;
};

/// Leaves the state a along the mode, scaled to `push`. Collective.
void escape(system::Model& model, Vec a, Vec mode, double push) {
  double largest = 0.0;
  VOILE_PETSC(VecNorm(mode, NORM_INFINITY, &largest));
  VOILE_PETSC(VecScale(mode, push / largest));
  VOILE_PETSC(VecAXPY(a, model.contact() ? model.contact()->step_fraction(a, mode) : 1.0, mode));
}

}  // namespace

struct Drape::Impl {
  system::Model& model;
  const DrapeOptions options;
  const Remark &remark, &progress;
  std::optional<Search> search;  ///< from `begin` on
  petsc::VecHandle mode;
  Stability now;
  bool done = false;
  double push = 0.0;                                                ///< of the last escape [cells]
  double escaped_energy = std::numeric_limits<double>::infinity();  ///< of the state that it left [J]

  Impl(system::Model& m, DrapeOptions o, const Remark& r, const Remark& p)
      : model(m), options(o), remark(r), progress(p), mode(linear::start_mode(m)) {}

  void judge(Vec a, NewtonResult& n);
  void conclude(system::State& state, StepResult& r);
  [[nodiscard]] StepResult attempt(system::State& state);
};

/// Stability of the state a, with its lowest mode. Collective.
void Drape::Impl::judge(Vec a, NewtonResult& n) {
  linear::LinearSolver& linear = search->newton().linear_solver();
  system::TangentRequest request;
  request.exact_contact = true;
  model.assemble_tangent(a, request);
  linear.tangent_changed();
  const bool factored = linear.factorise();
  n.negative_pivots = factored ? linear.certain_negative_eigenvalues() : -1;
  now.stable = n.negative_pivots == 0;
  now.eigenvalue = factored ? linear::inverse_iteration(model, linear, mode, inverse_iterations) : 0.0;
  if (factored) n.eigenvalue = now.eigenvalue;
  if (remark)
    remark(fmt::format("{} after {} iterations, residual {:.2e}, {} negative pivot(s)",
                       n.converged ? "equilibrium" : "no equilibrium", n.iterations, n.residual, n.negative_pivots));
}

StepResult Drape::Impl::attempt(system::State& state) {
  StepResult r;
  const int before = search->factorisations();
  if (now.escapes > 0 || !ramp(search->newton(), model, state.u, r.newton)) r.newton = search->run(state);
  judge(state.u, r.newton);
  r.newton_iterations = r.newton.iterations;
  if (r.newton.converged && r.newton.negative_pivots > 0 && now.escapes < options.max_escapes) {
    const double cell = std::sqrt(model.discretisation().mean_area());
    // A search that has come back to the state it was pushed from needs a longer push.
    const double energy = model.energy(state.u);
    const bool is_new = std::isinf(escaped_energy) || energy < escaped_energy - same_energy * std::abs(escaped_energy);
    push = is_new ? options.push : push_growth * push;
    escaped_energy = energy;
    escape(model, state.u, mode, push * cell);
    ++now.escapes;
    r.outcome = Outcome::not_yet;
  } else {
    conclude(state, r);
  }
  r.factorisations = search->factorisations() - before;
  return r;
}

void Drape::Impl::conclude(system::State& state, StepResult& r) {
  const petsc::VecHandle residual = model.dofs().create_vector();
  model.residual(state.u, residual);
  VOILE_PETSC(VecNorm(residual, NORM_2, &now.residual));
  // Of this state: normal forces that limit friction may have changed since the last iteration.
  if (const double force = model.force_scale(); force > 0.0) r.newton.residual = now.residual / force;
  now.fall_iterations = search->fall_iterations();
  ++state.step;
  state.load_factor = model.conditions().load_factor();
  state.in_equilibrium = r.newton.converged;
  r.taken = 1.0;
  if (remark)
    remark(fmt::format("residual {:.3e} N ({}); {}; eigenvalue nearest to zero {:.4g} 1/s^2", now.residual,
                       part_of_forces(r.newton.residual),
                       now.stable                     ? "stable"
                       : r.newton.negative_pivots < 0 ? "stability not known (follower loads without a potential)"
                                                      : "UNSTABLE",
                       now.eigenvalue));
  done = r.newton.converged && r.newton.negative_pivots <= 0;
  if (done) model.potential().end_step(state.u);
  if (done) return;
  r.outcome = Outcome::failed;
  r.worth_keeping = true;
  if (r.newton.converged) {
    r.reason = fmt::format("the equilibrium is unstable ({} negative pivots) after {} escapes",
                           r.newton.negative_pivots, now.escapes);
    return;
  }
  r.reason = r.newton.reason += "; " + largest_residuals_at(model, state.u);
}

Drape::Drape(system::Model& model, DrapeOptions options)
    : impl_(std::make_unique<Impl>(model, options, remarks(), progress())) {}
Drape::~Drape() = default;

StepResult Drape::begin(system::State& state) {
  impl_->model.conditions().set_load_factor(1.0);
  impl_->search.emplace(impl_->model, impl_->options, impl_->progress);
  state.v.reset();
  state.a.reset();
  return {};
}

bool Drape::finished(const system::State&) const {
  return impl_->done;
}

const Stability& Drape::stability() const {
  return impl_->now;
}

StepResult Drape::advance(system::State& state) {
  try {
    return impl_->attempt(state);
  } catch (const Interrupted& e) {  // not in equilibrium, but it can be gone on from there
    StepResult r;
    r.outcome = Outcome::failed;
    r.interrupted = r.worth_keeping = true;
    r.reason = e.what();
    ++state.step;
    state.load_factor = impl_->model.conditions().load_factor();
    state.in_equilibrium = false;
    return r;
  }
}

}  // namespace voile::solve

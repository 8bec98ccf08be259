#include "path_following.hpp"

#include <fmt/format.h>

#include "base/interrupt.hpp"
#include "path_following_impl.hpp"
#include "stall.hpp"
#include "voile/errors.hpp"

namespace voile::solve {

namespace {

constexpr int locating_steps = 12;
/// Of a step with several critical points: shorter ones have points that coincide.
constexpr double shortest_crowd = 0.05;
/// Of a step that has led off the path: shorter ones that fail end the search for it.
constexpr double shortest_doubt = 0.01, shortest_corner = 1e-3;
constexpr double crept = 0.1;  ///< of the largest speed of the probe, below which it is about to turn back
constexpr const char* singular = "the tangent is singular";
constexpr double located = 1e-5;  ///< critical eigenvalue, relative to those on both sides, at which a point is found

/// Extremum within (0, s) of the cubic with values y0, y1 and slopes d0, d1 of opposite sign at 0 and s.
double extremum(double s, double y0, double y1, double d0, double d1) {
  // Coefficients of the derivative in t = x/s: a t^2 + b t + c.
  const double a = 6.0 * (y0 - y1) + 3.0 * s * (d0 + d1), b = 6.0 * (y1 - y0) - 2.0 * s * (2.0 * d0 + d1), c = s * d0;
  const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * c));
  const double q = -0.5 * (b + (b >= 0.0 ? root : -root));
  double t = 0.5;
  for (const double candidate : {a != 0.0 ? q / a : -1.0, q != 0.0 ? c / q : -1.0})
    if (candidate >= 0.0 && candidate <= 1.0) t = candidate;
  const double h = t * t * (3.0 - 2.0 * t);
  return y0 + (y1 - y0) * h + s * (d0 * t * (1.0 - t) * (1.0 - t) - d1 * t * t * (1.0 - t));
}

std::string text_of_several(long modes) {
  return fmt::format(
      "{} modes become critical together, of which any mixture leaves the path: choose one by symmetry planes or an "
      "[[imperfection]]",
      modes);
}

}  // namespace

PathFollower::Impl::Constraint PathFollower::Impl::next_constraint(double length) const {
  if (options.control == Control::arc_length) return {Control::arc_length, length};
  const double rest = options.final_displacement - probed(accepted);
  // A remainder of less than a tenth of a step is taken along.
  return {Control::displacement,
          std::abs(rest) <= 1.1 * length ? options.final_displacement : probed(accepted) + std::copysign(length, rest)};
}

PathFollower::Impl::Constraint PathFollower::Impl::fraction(const Constraint& whole, double part) const {
  if (whole.kind == Control::arc_length) return {whole.kind, part * whole.value};
  const double from = probed(accepted);
  return {whole.kind, from + part * (whole.value - from)};
}

bool PathFollower::Impl::is_end(double probed, double lambda) const {
  if (options.final_displacement != 0.0)
    return std::abs(probed - options.final_displacement) <= 1e-9 * std::abs(options.final_displacement);
  return std::abs(lambda - options.final_load_factor) <= 1e-12 * std::max(1.0, std::abs(options.final_load_factor));
}

bool PathFollower::Impl::passes_end(Vec a, double lambda) const {
  if (options.control != Control::arc_length) return false;
  if (options.final_displacement != 0.0)
    return (probed(a) - options.final_displacement) * (probed(accepted) - options.final_displacement) <= 0.0;
  return (lambda - options.final_load_factor) * (factor - options.final_load_factor) <= 0.0;
}

/// From a state behind the end to the end itself.
NewtonResult PathFollower::Impl::land(Vec a, double& lambda) {
  const bool by_probe = options.final_displacement != 0.0;
  const double from = by_probe ? probed(accepted) : factor, to = by_probe ? probed(a) : lambda,
               end = by_probe ? options.final_displacement : options.final_load_factor;
  const double part = (end - from) / (to - from);
  VOILE_PETSC(VecScale(increment, part));
  lambda = by_probe ? factor + part * (lambda - factor) : end;
  return correct(a, lambda, {by_probe ? Control::displacement : Control::load, end});
}

/// One step from the accepted state; on the way past the end, the end.
NewtonResult PathFollower::Impl::attempt(Vec a, double& lambda, const Constraint& constraint) {
  predict(constraint, lambda);
  NewtonResult n = correct(a, lambda, constraint);
  iterations += n.iterations;
  if (n.converged && constraint.kind == Control::arc_length && rate * dot(increment, tangent_solution) < 0.0) {
    // As far away as wanted, but behind: where the path has turned by less than 180 degrees in a step it is not.
    n.converged = false;
    n.reason = "the iteration turned back along the path";
  }
  if (n.converged && !jumping && leaves_path(constraint)) {
    doubted = std::max(doubted, length);
    n.converged = false;
    n.reason = "the state found lies off the path";
  }
  if (!n.converged || !passes_end(a, lambda)) return n;
  const int before = n.iterations;
  n = land(a, lambda);
  iterations += n.iterations;
  n.iterations = std::max(n.iterations, before);
  return n;
}

std::optional<CriticalPoint::Kind> PathFollower::Impl::kind_between(double rate_before, long pivots_before,
                                                                    double rate_after, long pivots_after) const {
  const bool turned = rate_before * rate_after < 0.0;
  const bool known = pivots_before >= 0 && pivots_after >= 0;
  const long change = known ? pivots_after - pivots_before : 0;
  if (!turned && change == 0) return std::nullopt;
  if (!turned) return CriticalPoint::Kind::bifurcation;
  return std::abs(change) > 1 ? CriticalPoint::Kind::both : CriticalPoint::Kind::limit;
}

/// The critical point between the accepted state and the state increment, lambda with the tangent `after`.
std::optional<CriticalPoint> PathFollower::Impl::passed(const Tangent& after, double lambda) const {
  const double rate_after = rate_of(after), length = std::sqrt(dot(increment, increment));
  const auto kind = kind_between(rate, tangent.negative_pivots, rate_after, after.negative_pivots);
  if (!kind) return std::nullopt;
  CriticalPoint point;
  point.kind = *kind;
  // The load turns at a limit point, whose mode it pushes; also where a step has run over to the branch of a bifurcation, whose
  // mode is the one that follows.
  constexpr double same = 0.5;
  const bool follows = tangent.eigenvalue * after.eigenvalue < 0.0 && after.kept > same;
  if (point.kind == CriticalPoint::Kind::limit && follows && tangent.pushed < not_pushed)
    point.kind = CriticalPoint::Kind::bifurcation;
  point.step = steps + 1;
  if (point.kind == CriticalPoint::Kind::both || (point.kind == CriticalPoint::Kind::bifurcation && !follows))
    point.between = {factor, lambda};
  if (point.kind != CriticalPoint::Kind::bifurcation) {
    point.load_factor = extremum(length, factor, lambda, rate, rate_after);
  } else {
    const double before = tangent.eigenvalue, behind = after.eigenvalue;
    const double part = follows ? before / (before - behind) : 0.5;
    point.load_factor = factor + part * (lambda - factor);
  }
  return point;
}

/// Shortens a step across a critical point until it ends there: regula falsi on the critical eigenvalue, held within
/// the bracket that the negative pivots give. The state that is found is as a failed attempt if no step converges.
NewtonResult PathFollower::Impl::locate(Vec a, double& lambda, const Constraint& constraint, Tangent& after) {
  double low = 0.0, high = 1.0, low_value = tangent.eigenvalue, high_value = after.eigenvalue;
  const double size = std::max(std::abs(low_value), std::abs(high_value));
  NewtonResult n;
  for (int k = 0; k < locating_steps; ++k) {
    const double fraction_of = low_value * high_value < 0.0 ? low_value / (low_value - high_value) : 0.5;
    const double part = low + std::clamp(fraction_of, 0.05, 0.95) * (high - low);
    bool is_singular = false;
    // Where the tangent is singular to round-off the point is there: a little before it the load is the same.
    for (double short_of = 0.0; short_of < 0.1; short_of = std::max(10.0 * short_of, 1e-4)) {
      predict(fraction(constraint, part * (1.0 - short_of)), lambda);
      n = correct(a, lambda, fraction(constraint, part * (1.0 - short_of)));
      iterations += n.iterations;
      if (!n.converged) return n;
      after = tangent_at(a);
      if (after.good) break;
      is_singular = true;
    }
    if (is_singular) break;
    const bool behind = after.negative_pivots != tangent.negative_pivots;
    (behind ? high : low) = part;
    (behind ? high_value : low_value) = after.eigenvalue;
    if (std::abs(after.eigenvalue) <= located * size) break;
  }
  return n;
}

/// Leaves the accepted critical state along its mode.
NewtonResult PathFollower::Impl::branch(Vec a, double& lambda, double length) {
  const double size = std::abs(options.branch_step) * length;
  VOILE_PETSC(VecCopy(mode, increment));
  VOILE_PETSC(VecScale(increment, std::copysign(size, options.branch_step)));
  lambda = factor;
  NewtonResult n = correct(a, lambda, {Control::arc_length, size});
  iterations += n.iterations;
  if (n.converged && std::abs(dot(increment, mode)) < 0.1 * size) {
    n.converged = false;
    n.reason = "the iteration fell back to the path it came from";
  }
  return n;
}

void PathFollower::Impl::accept(Vec a, double lambda, const Tangent& after) {
  rate = rate_of(after);
  VOILE_PETSC(VecCopy(increment, previous));
  VOILE_PETSC(VecCopy(a, accepted));
  VOILE_PETSC(VecCopy(load_solution, tangent_solution));
  if (options.control == Control::displacement) longest = std::max(longest, std::abs(probed(increment)));
  fastest = std::max(fastest, probe_speed());
  factor = lambda;
  tangent = after;
  force = std::max(force, model.force_scale());
  ++steps;
}

/// A step, or a step along the mode if `branching`; cut to end at a critical point where the path is to stop or branch.
PathFollower::Impl::Attempt PathFollower::Impl::try_step(Vec a, double& lambda) {
  Attempt t;
  const Constraint constraint = next_constraint(length);
  const int before = linear.factorisations();
  t.newton = branching ? branch(a, lambda, length) : attempt(a, lambda, constraint);
  if (t.newton.converged) t.after = tangent_at(a);
  if (t.newton.converged && t.after.good && !branching) t.bend = bend_of(t.after);
  if (t.newton.converged && t.after.good && !branching && !jumping && has_jumped(constraint, t.bend)) {
    doubted = std::max(doubted, length);
    t.newton.converged = false;
    t.newton.reason = "the state found lies off the path";
  }
  if (t.newton.converged && t.after.good && !branching && !jumping) t.critical = passed(t.after, lambda);
  if (t.critical && is_doubtful(*t.critical, t.after)) {
    t.critical.reset();
    t.newton.converged = false;
    t.newton.reason = "critical points within the step are not distinguished";
  }
  t.found = t.critical && (options.at_critical_point == AtCriticalPoint::stop ||
                           (may_branch && t.critical->kind != CriticalPoint::Kind::limit));
  if (t.found) {
    t.newton = locate(a, lambda, constraint, t.after);
    t.critical->load_factor = lambda;
    t.critical->between.reset();
  }
  if (t.newton.converged && !t.after.good) {
    t.newton.converged = false;
    t.newton.reason = singular;
  }
  t.newton.factorisations = linear.factorisations() - before;
  t.newton.negative_pivots = t.after.certain;
  return t;
}

/// Whether a step passes several critical points, or a bifurcation whose mode is not followed: it may have gone over to another branch.
/// Not close to where the first such step began: there several coincide.
bool PathFollower::Impl::is_doubtful(const CriticalPoint& point, const Tangent& after) {
  const bool several = std::abs(after.negative_pivots - tangent.negative_pivots) > 1;
  if (!several && !point.between) return false;
  crowded = std::max(crowded, length);
  return length >= shortest_crowd * crowded;
}

/// One step, or a failed attempt at it.
StepResult PathFollower::Impl::advance(system::State& state) {
  StepResult r;
  double lambda = factor;
  const int before = linear.factorisations(), iterations_before = iterations;
  const Attempt t = try_step(state.u, lambda);
  r.newton = t.newton;
  r.newton_iterations = iterations - iterations_before;
  r.factorisations = linear.factorisations() - before;
  if (!t.newton.converged) {
    halve(state, r);
    return r;
  }
  r.reason = ran_away(state.u, lambda);
  if (!r.reason.empty()) {
    r.outcome = Outcome::failed;
    VOILE_PETSC(VecCopy(accepted, state.u));
    model.conditions().set_load_factor(factor);
    return r;
  }
  if (t.found && may_branch) together = std::abs(t.after.negative_pivots - tangent.negative_pivots);
  if (!state.previous) state.previous = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(accepted, state.previous));
  accept(state.u, lambda, t.after);
  jumping = false;
  crowded = 0.0;
  lengthened = 0;
  if (options.control == Control::arc_length || length >= doubted) doubted = 0.0;
  model.potential().end_step(state.u);
  r.taken = std::sqrt(dot(previous, previous)) / unit;
  state.step = steps;
  state.load_factor = factor;
  state.v.reset();
  state.a.reset();
  branching = t.found && may_branch;
  if (branching) may_branch = false;
  stopped = t.found && options.at_critical_point == AtCriticalPoint::stop;
  r.critical = t.critical;
  r.mode = t.found ? static_cast<Vec>(mode) : nullptr;
  if (t.critical && remark) remark(text_of(*t.critical));
  if (branching && together > 1 && remark) remark(text_of_several(together));
  const double growth = std::sqrt(static_cast<double>(options.target_iterations) / std::max(1, t.newton.iterations));
  if (!t.found)
    length = std::min(options.max_step * unit, length * std::clamp(std::min(growth, straighter(t.bend)), 0.5, 2.0));
  state.next_step = length / unit;
  state.path.unit = options.control == Control::arc_length ? unit : 0.0;
  state.path.rate = rate;
  state.path.doubted = doubted;
  state.path.negative_pivots = tangent.negative_pivots;
  state.path.has_branched = options.at_critical_point == AtCriticalPoint::switch_branch && !may_branch && !branching;
  ++state.path.steps;
  return r;
}

/// Where a branch is flat its tangent stays singular near the bifurcation: a longer step passes that. Returns whether one is to be
/// tried.
bool PathFollower::Impl::lengthen(const StepResult& r) {
  constexpr int most = 5;
  constexpr double growth = 4.0;
  if (r.newton.reason == singular && lengthened >= 0 && lengthened < most &&
      growth * length <= options.max_step * unit) {
    ++lengthened;
    length *= growth;
    return true;
  }
  if (lengthened > 0) length /= std::pow(growth, lengthened);
  if (lengthened > 0) lengthened = -1;
  return false;
}

/// After an attempt that failed.
void PathFollower::Impl::halve(system::State& state, StepResult& r) {
  if (lengthen(r)) {
    VOILE_PETSC(VecCopy(accepted, state.u));
    model.conditions().set_load_factor(factor);
    if (remark)
      remark(fmt::format("load factor {:.6g}: {}{}; step lengthened to {:.3g}", factor, branching ? "branching: " : "",
                         r.newton.reason, length / unit));
    r.outcome = Outcome::not_yet;
    return;
  }
  const double shortest = options.control == Control::arc_length
                              ? std::max(shortest_corner * doubted, options.min_step * unit)
                              : shortest_doubt * doubted;
  const bool ends = 0.5 * length < options.min_step * unit;
  // Steps that creep to where the probe turns back do not get beyond.
  if (ends && !jumping && probe_speed() < crept * fastest) doubted = longest;
  const bool searched = doubted > 0.0 && (0.5 * length < shortest || ends) && !jumping;
  const bool last = !searched && ends;
  const bool round_off = r.newton.reason == singular;
  const std::string place = !last          ? ""
                            : together > 1 ? "; " + text_of_several(together)
                            : round_off    ? ", as on a flat branch: begin beside it, with an [[imperfection]]"
                                           : "; " + largest_residuals_at(model, state.u);
  VOILE_PETSC(VecCopy(accepted, state.u));
  model.conditions().set_load_factor(factor);
  length *= 0.5;
  if (remark)
    remark(fmt::format("load factor {:.6g}: {}{} after {} iterations; step halved to {:.3g}", factor,
                       branching ? "branching: " : "", r.newton.reason, r.newton.iterations, length / unit));
  if (searched) jump_next();
  r.outcome = last ? Outcome::failed : Outcome::not_yet;
  if (last)
    r.reason = fmt::format(
        "no equilibrium found beyond load factor {:.6g} with steps of {:.3g} or more; the last attempt ended with {}{}",
        factor, options.min_step, r.newton.reason, place);
}

PathFollower::PathFollower(system::Model& model, StaticOptions options, Vec probe)
    : impl_(std::make_unique<Impl>(model, std::move(options), remarks(), probe)) {}
PathFollower::~PathFollower() = default;

StepResult PathFollower::begin(system::State& state) {
  StepResult r = find_equilibrium(impl_->model, state);
  if (r.outcome == Outcome::failed) return r;
  const int before = impl_->linear.factorisations();
  impl_->begin(state, r);
  r.factorisations += impl_->linear.factorisations() - before;
  return r;
}

NewtonResult PathFollower::regain(system::State& state, double probed_before) {
  return impl_->regain(state, probed_before);
}

bool PathFollower::finished(const system::State&) const {
  return impl_->stopped || impl_->at_end();
}

StepResult PathFollower::advance(system::State& state) {
  Impl& p = *impl_;
  StepResult r;
  r.outcome = Outcome::failed;
  if (state.path.steps >= p.options.max_steps) {
    r.reason = fmt::format("max_steps = {} steps did not reach the end of the path", p.options.max_steps);
    return r;
  }
  try {
    return p.advance(state);
  } catch (const Interrupted& e) {
    VOILE_PETSC(VecCopy(p.accepted, state.u));
    p.model.conditions().set_load_factor(p.factor);
    r.interrupted = true;
    r.reason = e.what();
    return r;
  }
}

}  // namespace voile::solve

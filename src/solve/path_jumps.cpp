// Path following: steps that end on another path.
//
// Symbols   t0, t1   unit tangents of the path at both ends of a step, in its direction
//           Da       what the step adds
// A smooth path leads along the bisector of its tangents: Da || t0 + t1, to third order in the length of the step.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "path_following_impl.hpp"

namespace voile::solve {

namespace {

constexpr double smooth_aside = 0.1;  // of |Da|: a path that turns by 45 degrees has a few hundredths
constexpr double most_aside = 0.4;    // of |Da|, at which a step leads to another path
constexpr double sharpest = 0.0;  // cosine of the angle between the tangents: paths may turn by 90 degrees in a step
constexpr double wanted = 0.25 * std::numbers::pi;  // angle that the next step shall have at most

}  // namespace

/// Where the controlled displacement turns back (snap-back), the next larger one belongs to another path, as far away however
/// short the step: |Da - prediction| > |prediction|.
bool PathFollower::Impl::leaves_path(const Constraint& constraint) const {
  if (constraint.kind != Control::displacement) return false;
  const double change = (constraint.value - probed(accepted)) / probed(tangent_solution);
  return dot(increment, increment) > 2.0 * change * dot(increment, tangent_solution);
}

/// Of the step `increment` to the state with the tangent `after`.
PathFollower::Impl::Bend PathFollower::Impl::bend_of(const Tangent& after) const {
  const double length = std::sqrt(dot(increment, increment));
  const double before = rate, behind = rate_of(after);
  const double cosine = std::clamp(before * behind * dot(tangent_solution, load_solution), -1.0, 1.0);
  const double along = (before * dot(increment, tangent_solution) + behind * dot(increment, load_solution)) / length;
  const double part = std::min(1.0, along * along / (2.0 + 2.0 * cosine));  // of Da, squared, along the bisector
  return {cosine, std::sqrt(1.0 - part)};
}

/// After the fact: the tangents at both ends do not lead from one to the other.
bool PathFollower::Impl::has_jumped(const Constraint& constraint, const Bend& bend) const {
  if (!(bend.cosine >= sharpest && bend.aside <= smooth_aside)) return true;
  if (constraint.kind != Control::displacement) return false;
  const double half = 0.5 * (constraint.value - probed(accepted));
  VOILE_PETSC(VecCopy(increment, last_mode));
  VOILE_PETSC(VecAXPY(last_mode, -half / probed(tangent_solution), tangent_solution));
  VOILE_PETSC(VecAXPY(last_mode, -half / probed(load_solution), load_solution));
  return !(dot(last_mode, last_mode) <= most_aside * most_aside * dot(increment, increment));
}

/// By what the next step may be longer, for a path that goes on turning as it does.
double PathFollower::Impl::straighter(const Bend& bend) const {
  if (options.control != Control::arc_length) return 2.0;
  const double turn = std::acos(bend.cosine);
  return turn > 0.5 * wanted ? wanted / turn : 2.0;
}

/// Why a path that leads to nowhere ends; empty if it does not.
std::string PathFollower::Impl::ran_away(Vec a, double lambda) const {
  constexpr double most = 100.0;  // of the extent
  double largest = 0.0;
  VOILE_PETSC(VecNorm(a, NORM_INFINITY, &largest));
  if (largest <= most * model.dofs().mesh().extent()) return "";
  return fmt::format(
      "the path has run away to load factor {:.3g}, displacements are beyond {:g} times the extent of the sheet: it "
      "has turned back, or missed the end that [steps] gives; history.csv shows where",
      lambda, most);
}

/// How far the controlled displacement changes per length of the path, at the accepted state.
double PathFollower::Impl::probe_speed() const {
  return options.control == Control::displacement ? std::abs(rate * probed(tangent_solution)) : 0.0;
}

/// No step shorter than the one that has first led off the path stays on it: on, as far as the path may have turned back or,
/// along an arc, as short as may be.
void PathFollower::Impl::jump_next() {
  jumping = true;
  const bool turns_back = options.control == Control::displacement;
  if (turns_back) length = doubted;
  doubted = 0.0;
  if (!remark) return;
  if (turns_back)
    remark(fmt::format(
        "load factor {:.6g}: control_probe turns back (snap-back), and the next step jumps to another path; "
        "control = \"arc_length\" follows this one",
        factor));
  else
    remark(fmt::format(
        "load factor {:.6g}: the path has a corner that shorter steps do not round, and the next step may lead to "
        "another branch; an [[imperfection]] rounds it",
        factor));
}

}  // namespace voile::solve

#include "drape_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/interrupt.hpp"
#include "system/contact.hpp"
#include "system/dynamics.hpp"
#include "time_integration.hpp"

namespace voile::solve {

namespace {

/// Steps, in T: the first, the largest and the smallest; and the tolerance of a step's velocities, in cells per T.
constexpr double first_step = 0.2, largest_step = 1.0, smallest_step = 1e-4, velocity_tolerance = 0.01;
/// So many slow peaks in a row are rest.
constexpr int peaks_of_rest = 2;
/// What has flown so many extents of the sheet is held by nothing.
constexpr double far_away = 50.0;
/// Steps between two words on the progress.
constexpr int remark_every = 20;

/// T of drape_motion.hpp; 0 if no force acts. Collective.
double time_of_a_cell(system::Model& model, Vec a) {
  petsc::VecHandle force = model.dofs().create_vector(), acceleration = model.dofs().create_vector();
  const auto mean_square = [&] {
    double square = 0.0, mass = 0.0;
    model.dofs().clear_fixed(force);
    VOILE_PETSC(VecPointwiseDivide(acceleration, force, model.potential().constant().mass()));
    VOILE_PETSC(VecDot(acceleration, force, &square));
    VOILE_PETSC(VecSum(model.potential().constant().mass(), &mass));
    return 3.0 * square / mass;
  };
  model.load_direction(a, force);
  double square = mean_square();
  if (!(square > 0.0)) {  // only what is there at any load factor
    model.residual(a, force);
    square = mean_square();
  }
  const double cell = std::sqrt(model.discretisation().mean_area());
  return square > 0.0 ? std::sqrt(2.0 * cell / std::sqrt(square)) : 0.0;
}

system::DynamicsOptions at_load(double factor) {
  system::DynamicsOptions options;
  options.any_mass = true;
  options.material_damping = false;
  options.load_history = [factor](double) { return factor; };
  return options;
}

TimeOptions steps_of(double unit, double cell) {
  TimeOptions options;
  options.step = first_step * unit;
  options.max_step = largest_step * unit;
  options.min_step = smallest_step * unit;
  options.end_time = 1e9 * unit;
  options.radius = 0.0;
  options.velocity_tolerance = velocity_tolerance * cell / unit;
  return options;
}

/// Follows the motion, stops it at its peaks and tells when it is over.
class KineticDamping {
 public:
  KineticDamping(const system::Model& model, const system::Dynamics& dynamics, double unit)
      : model_(model), dynamics_(dynamics), unit_(unit), cell_(std::sqrt(model.discretisation().mean_area())) {
    VOILE_PETSC(VecSum(model.potential().constant().mass(), &mass_));
    mass_ /= 3.0;
  }
  /// True if the motion is over. Collective.
  bool step(const system::State& state, double rest_speed) {
    const double kinetic = dynamics_.kinetic_energy(state.v);
    speed = std::sqrt(2.0 * kinetic / mass_) * unit_ / cell_;
    const bool peak = kinetic < last_;
    last_ = peak ? 0.0 : kinetic;
    if (peak) {
      VOILE_PETSC(VecZeroEntries(state.v));
      slow_ = speed < rest_speed ? slow_ + 1 : 0;
    }
    double distance = 0.0;
    VOILE_PETSC(VecNorm(state.u, NORM_INFINITY, &distance));
    endless = distance > far_away * model_.dofs().mesh().extent();
    return endless || slow_ == peaks_of_rest;
  }
  double speed = 0.0;  ///< root mean square over the mass [cells per T]
  bool endless = false;

 private:
  const system::Model& model_;
  const system::Dynamics& dynamics_;
  double unit_, cell_, mass_ = 0.0, last_ = 0.0;
  int slow_ = 0;
};

}  // namespace

FallResult fall_to_rest(system::Model& model, system::State& state, double rest_speed, int max_iterations,
                        const Stepper::Remark& remark) {
  FallResult result;
  system::Contact* contact = model.contact();
  const double now = contact ? contact->scene().time() : 0.0;
  system::settle_contact(model, state.u, now);
  const double unit = time_of_a_cell(model, state.u), factor = model.conditions().load_factor();
  result.rested = unit == 0.0;
  if (result.rested) return result;
  system::State falling;
  falling.time = now;
  falling.u = petsc::fraction(state.u);
  system::Dynamics dynamics(model, at_load(factor));
  // Inexact systems are no gain here: from where such a fall ends the search for equilibrium takes longer.
  TimeIntegration motion(dynamics, steps_of(unit, std::sqrt(model.discretisation().mean_area())), false);
  KineticDamping damping(model, dynamics, unit);
  model.hold_still(true);
  int iterations = 0;
  const RunStatistics done = follow(motion, falling, [&](const system::State& s, const StepResult& r) {
    if (r.taken == 0.0) return false;
    iterations += r.newton.iterations;
    result.rested = damping.step(s, rest_speed) && !damping.endless;
    if (remark && s.step % remark_every == 0)
      remark(fmt::format("fall: {} steps, {} iterations, {:.2e} cells per step of full size", s.step, iterations,
                         damping.speed));
    return result.rested || damping.endless || iterations >= max_iterations;
  });
  model.conditions().set_load_factor(factor);
  model.hold_still(false);
  if (contact) {
    contact->set_time(now);
    contact->restore({});
  }
  if (done.interrupted) throw Interrupted();
  result.endless = damping.endless;
  result.steps = done.steps;
  result.iterations = done.newton_iterations;
  result.factorisations = done.factorisations;
  if (result.endless)
    result.reason = fmt::format("the sheet has flown {:g} of its extents: nothing holds it", far_away);
  else if (!result.rested)
    result.reason =
        done.reason.empty() ? fmt::format("the fall continues after {} iterations", iterations) : done.reason;
  return result;
}

}  // namespace voile::solve

// The stability limit of central differences, found at the start and followed while the sheet stiffens.
//
// Symbols   omega   largest frequency of the undamped sheet     c   largest rate of its damping, c = max x.C x / x.M x [1/s]
//   (omega h/2)^2 + c h/2 <= 1,  as velocities are those of half a step before:   h = 2/(c/2 + sqrt(omega^2 + c^2/4))
#include <fmt/format.h>
#include <petsc/private/tsimpl.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "linear/inverse_iteration.hpp"
#include "time_integration_impl.hpp"

namespace voile::solve {

namespace {

/// Fraction of the limit that a step takes: between two looks the frequency may rise by a tenth.
constexpr double safe_fraction = 0.9;
/// A change of the frequency below which the next look waits twice as long, at most so many steps; beyond, half as long.
constexpr double small_change = 0.02;
constexpr int longest_wait = 64;
/// Fraction of the limit last printed below which a lower one is printed too.
constexpr double worth_saying = 0.8;

/// Takes x to M^-1 (the operator times x), of size one before, until its size, the eigenvalue, does not change. Returns it.
template <class Apply>
double power_iteration(system::Model& model, petsc::VecHandle& x, const Apply& apply) {
  petsc::VecHandle y = model.dofs().create_vector();
  double estimate = 0.0;
  for (int k = 0; k < 100; ++k) {
    model.dofs().clear_fixed(x);
    double size = 0.0, next = 0.0;
    VOILE_PETSC(VecNorm(x, NORM_2, &size));
    VOILE_PETSC(VecScale(x, 1.0 / size));
    apply(x, y);
    VOILE_PETSC(VecPointwiseDivide(x, y, model.potential().constant().mass()));
    model.dofs().clear_fixed(x);
    VOILE_PETSC(VecNorm(x, NORM_2, &next));
    const bool settled = k > 10 && std::abs(next - estimate) <= 1e-4 * next;
    estimate = next;
    if (settled || !(next > 0.0)) break;
  }
  return 1.02 * estimate;  // the last percent may be missing from below
}

/// The power iteration begins with the last mode and as much of all others: another part of the sheet may have become the stiffest.
double largest_frequency(system::Dynamics& dynamics, Vec u, petsc::VecHandle& mode) {
  system::Model& model = dynamics.model();
  model.assemble_tangent(u, {.kind = energy::Tangent::exact});
  petsc::VecHandle x = linear::start_mode(model);
  if (mode) {
    double size = 0.0;
    VOILE_PETSC(VecNorm(x, NORM_2, &size));
    VOILE_PETSC(VecAXPY(x, size, mode));
  }
  const double square = power_iteration(model, x, [&](Vec from, Vec to) { model.tangent().multiply(from, to); });
  double size = 0.0;
  VOILE_PETSC(VecNorm(x, NORM_2, &size));
  if (size > 0.0) VOILE_PETSC(VecScale(x, 1.0 / size));
  mode = std::move(x);
  return std::sqrt(square);
}

/// c: of what turns against velocities, and an upper bound of what the viscosity of the membrane adds, tau omega^2.
double damping_rate(system::Dynamics& dynamics, double frequency) {
  system::Model& model = dynamics.model();
  petsc::VecHandle x = linear::start_mode(model), wind = model.dofs().create_vector();
  dynamics.add_damping(petsc::VecHandle(model.dofs().create_vector()), wind);  // acts at no velocity, too
  const double rate = power_iteration(model, x, [&](Vec from, Vec to) {
    VOILE_PETSC(VecZeroEntries(to));
    dynamics.add_damping(from, to);
    VOILE_PETSC(VecAXPY(to, -1.0, wind));
  });
  return rate + dynamics.longest_viscous_time() * frequency * frequency;
}

/// Of steps, for these.
double stable_step(double frequency, double rate) {
  return 2.0 / (0.5 * rate + std::hypot(frequency, 0.5 * rate));
}

}  // namespace

double largest_frequency(system::Dynamics& dynamics, Vec u) {
  petsc::VecHandle mode;
  return largest_frequency(dynamics, u, mode);
}

void TimeIntegration::Impl::limit_explicit_step(double limit) {
  options.max_step = std::min(stability.most, safe_fraction * limit);
  options.min_step = std::min(stability.least, options.max_step);
  TSAdapt adapt = nullptr;
  VOILE_PETSC(TSGetAdapt(ts, &adapt));
  VOILE_PETSC(TSAdaptSetStepLimits(adapt, options.min_step * (1.0 - 1e-9), options.max_step));
}

void TimeIntegration::Impl::set_explicit_step(const system::State& from) {
  double h = 0.0;
  VOILE_PETSC(TSGetTimeStep(ts, &h));
  stability.most = options.max_step;
  stability.least = options.min_step;
  system::StabilityMemory& memory = stability.memory;
  dynamics.start_step(from.u, from.v, HUGE_VAL);  // no viscosity in the tangent
  const double frequency = largest_frequency(dynamics, from.u, stability.mode);
  // A restart continues with what the unbroken run knew, unless another case has made it wrong.
  const bool known = from.stiffest && std::abs(frequency - from.stability.frequency) < 0.1 * frequency;
  memory = known ? from.stability : system::StabilityMemory{};
  if (known)
    VOILE_PETSC(VecCopy(from.stiffest, stability.mode));
  else
    memory.frequency = frequency;
  stability.damping = damping_rate(dynamics, memory.frequency);
  const double limit = stable_step(memory.frequency, stability.damping);
  if (!known) memory.said = limit;
  if (remark) remark(fmt::format("central differences: stability limit {:.4g} s", limit));
  limit_explicit_step(limit);
  if (h <= options.max_step) return;
  if (remark) remark(fmt::format("step reduced from {:.4g} s to {:.4g} s", h, options.max_step));
  VOILE_PETSC(TSSetTimeStep(ts, options.max_step));
}

void TimeIntegration::Impl::keep_stability(system::State& state) {
  const bool looked = follow_stability(state);
  state.stability = stability.memory;
  if (state.stiffest && !looked) return;
  if (!state.stiffest) state.stiffest = model.dofs().create_vector();
  VOILE_PETSC(VecCopy(stability.mode, state.stiffest));
}

/// Whether it was time to look.
bool TimeIntegration::Impl::follow_stability(const system::State& state) {
  system::StabilityMemory& memory = stability.memory;
  if (--memory.left > 0) return false;
  dynamics.set_time(state.time);
  dynamics.start_step(state.u, state.v, HUGE_VAL);
  const double frequency = largest_frequency(dynamics, state.u, stability.mode);
  stability.damping = damping_rate(dynamics, frequency);
  double h = 0.0;
  VOILE_PETSC(TSGetTimeStep(ts, &h));
  if (under_way.u)
    dynamics.resume_step(under_way);  // what is recorded of this step has its drag and viscosity
  else
    dynamics.start_step(state.u, state.v, h);
  memory.left = 1;
  if (!std::isfinite(frequency)) return false;  // the motion is lost; what was known tells why
  const double change = std::abs(frequency / std::exchange(memory.frequency, frequency) - 1.0);
  memory.wait = change < small_change ? std::min(2 * memory.wait, longest_wait) : std::max(1, memory.wait / 2);
  memory.left = memory.wait;
  const double limit = stable_step(frequency, stability.damping);
  if (!std::isfinite(limit)) return true;
  limit_explicit_step(limit);
  if (h <= options.max_step) return true;
  if (limit < worth_saying * memory.said) {
    memory.said = limit;
    if (remark)
      remark(
          fmt::format("t = {:.6g} s: the sheet has become stiffer: stability limit {:.4g} s, step reduced to {:.4g} s",
                      state.time, limit, options.max_step));
  }
  VOILE_PETSC(TSSetTimeStep(ts, options.max_step));
  wanted = std::min(wanted, options.max_step);
  return true;
}

}  // namespace voile::solve
